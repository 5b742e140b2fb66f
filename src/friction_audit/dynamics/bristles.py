"""Bristles: friction that builds up with the path since a reversal, for any formula.

What a term gives after a reversal from steady sliding is one curve: the torque against the path since then. There are
two models of what happens after a shorter stroke. In Dahl's, the slope depends on the torque and the direction alone:
from any torque bristles go on along the curve, or along its mirror image. In the Maxwell-slip model, bristles are
springs in parallel that slip one after the other and remember every reversal until a larger loop closes; a curve that
rises ever more slowly is as many straight pieces as there are springs. A damping in proportion to the rate of the
torque is found too.

References:
    P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1, 1968.
    F. Al-Bender, V. Lampaert, J. Swevers, The generalized Maxwell-slip model, IEEE Transactions on Automatic Control 50
    (2005) 1883.
"""

from typing import NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.joint_log import Float, read_only

PATH_RAD, STEP_RAD = 0.4, 1e-5  # stroke before and after the reversal, longer than any bristle bends, and its grid
POINTS = 400  # of a curve, at even steps of the torque, and as many of the path
SPRINGS = 24
LEAST_SHARE = 1e-6  # a spring that bears less of the torque is left out
SLOW_RAD_S, FAST_RAD_S = 1e-3, 0.1  # speeds at which a term is asked; the difference is its damping


class Bristles(NamedTuple):
    """Bristles by their curve of k points, as Dahl has it, or as m springs."""

    path: Float  # path since a reversal to backwards, rising from 0, shape (k,) [rad]
    torque: Float  # what they take there, falling, shape (k,) [N m]
    stiffness: Float  # of each spring, shape (m,) [N m/rad]
    reach: Float  # deflection at which it slips, shape (m,) [rad]
    damping_s: float  # damping over stiffness [s]

    def states_along(self, q: Float) -> Float:
        """State along a motion that begins unbent: torque of the curve, deflections of springs, shape (n, 1 + m)."""
        return np.asarray(_follow(read_only(q), self))

    def along(self, q: Float) -> Float:
        """Torque along a motion that begins unbent, without damping, shape (n,). [N m]"""
        states = self.states_along(q)
        return np.asarray(states[:, 0] + states[:, 1:] @ self.stiffness)


NO_BRISTLES = Bristles(path=np.zeros(0), torque=np.zeros(0), stiffness=np.zeros(0), reach=np.zeros(0), damping_s=0.0)


def bristles_of(term: Term) -> tuple[float, Bristles, Bristles]:
    """Return the dry friction that a term adds, below zero where bristles replace it; these as curve and springs."""
    before, slow = _reversal(term, SLOW_RAD_S)
    # At the reversal the direction jumps at once, the bristles do not; the first sample after it is a step further.
    dry = -0.5 * (2.0 * slow[0] - slow[1] - before)
    curve = np.minimum.accumulate(np.append(before - dry, slow + dry))
    path = np.asarray(STEP_RAD * np.arange(len(curve)), np.float64)
    rate = np.gradient(curve, STEP_RAD)[1:]
    more = _reversal(term, FAST_RAD_S)[1] - slow
    square = float(rate[1:] @ rate[1:])
    damping = float(rate[1:] @ more[1:]) / square / (FAST_RAD_S - SLOW_RAD_S) if square > 0.0 else 0.0
    damped = NO_BRISTLES._replace(damping_s=max(damping, 0.0))
    # Points of the curve at even steps of its height and of the logarithm of its path.
    last = len(curve) - 1
    heights = np.searchsorted(-curve, -np.linspace(curve[0], curve[-1], POINTS)).clip(max=last)
    chosen = np.unique(np.concatenate([[0], heights, np.rint(np.geomspace(1, last, POINTS)).astype(int)]))
    dahl = damped._replace(path=path[chosen], torque=curve[chosen])
    # Springs whose curve has the same height at even steps of it: each turns over twice its reach.
    built = curve[0] - curve
    knots = np.searchsorted(built, built[-1] * np.arange(1, SPRINGS + 1) / SPRINGS * (1.0 - 1e-9))
    knots = np.unique(np.append(0, np.minimum(knots, last)))
    slopes = np.append(np.diff(built[knots]) / np.diff(path[knots]), 0.0)
    stiffness, reach = np.maximum(-np.diff(slopes), 0.0), 0.5 * path[knots[1:]]
    bears = stiffness * reach > LEAST_SHARE * built[-1]
    return float(dry), dahl, damped._replace(stiffness=stiffness[bears], reach=reach[bears])


def _reversal(term: Term, speed: float) -> tuple[float, Float]:
    """Torque just before the reversal of a long stroke, and at every step after it. [N m]"""
    steps = round(PATH_RAD / STEP_RAD)
    there = STEP_RAD * np.arange(steps + 1)
    q = np.concatenate([there, there[-2::-1]])
    still = np.zeros(len(q))
    dq = np.where(np.arange(len(q)) <= steps, speed, -speed)
    t = np.asarray(np.arange(len(q)) * (STEP_RAD / speed), np.float64)
    torque = term.torque(Motion(t=t, q=q, dq=dq, ddq=still, rest=still))
    # A derivative is smeared over the reversal; the torque of steady sliding holds at the sample before.
    return float(torque[steps - 2]), torque[steps + 1 :]


@compiled()
def bend(held: float, displacement: float, bristles: Bristles) -> float:
    """Return the torque of bristles of a curve after a signed displacement. [N m]"""
    path, torque = bristles.path, bristles.torque
    if len(path) == 0 or displacement == 0.0:
        return held
    sign = -1.0 if displacement > 0.0 else 1.0
    low = _before(sign * held, torque)
    drop = torque[low] - torque[low + 1]
    share = min(1.0, max(0.0, (torque[low] - sign * held) / drop)) if drop > 0.0 else 1.0
    on = path[low] + share * (path[low + 1] - path[low]) + abs(displacement)
    if on <= path[0] or on >= path[-1]:
        return float(sign * (torque[0] if on <= path[0] else torque[-1]))
    low = np.searchsorted(path, on) - 1
    share = (on - path[low]) / (path[low + 1] - path[low])
    return float(sign * (torque[low] + share * (torque[low + 1] - torque[low])))


@compiled(inline=True)
def _before(value: float, torque: Float) -> int:
    """Return the point of a falling curve before a torque."""
    low = len(torque) - 1 - int(np.searchsorted(torque[::-1], value))
    return min(max(low, 0), len(torque) - 2)


@compiled(inline=True)
def stretch(deflection: float, displacement: float, reach: float) -> float:
    """Return the deflection of a spring after a displacement, beyond whose reach it slips. [rad]"""
    return min(reach, max(-reach, deflection + displacement))


@compiled(inline=True)
def bristle_nm(bent: Float, displacement: float, bristles: Bristles) -> float:
    """Return the torque of the bristles a displacement ahead, without damping. [N m]"""
    torque = bend(bent[0], displacement, bristles)
    for k in range(len(bristles.reach)):
        torque += bristles.stiffness[k] * stretch(bent[1 + k], displacement, bristles.reach[k])
    return torque


@compiled(inline=True)
def bend_on(bent: Float, displacement: float, bristles: Bristles) -> None:
    """Let the bristles follow a displacement, in place."""
    bent[0] = bend(bent[0], displacement, bristles)
    for k in range(len(bristles.reach)):
        bent[1 + k] = stretch(bent[1 + k], displacement, bristles.reach[k])


@compiled(inline=True)
def bristle_damping(bent: Float, sign: float, bristles: Bristles) -> float:
    """Return the damping of the bristles that bend on in a direction. [N m s/rad]"""
    if bristles.damping_s == 0.0:
        return 0.0
    stiffness, path, torque = 0.0, bristles.path, bristles.torque
    if len(path) > 0:
        low = _before(-sign * bent[0], torque)
        stiffness = (torque[low] - torque[low + 1]) / (path[low + 1] - path[low])
    for k in range(len(bristles.reach)):
        if bent[1 + k] * sign < bristles.reach[k]:
            stiffness += bristles.stiffness[k]
    return float(bristles.damping_s * stiffness)


@compiled()
def _follow(q: Float, bristles: Bristles) -> Float:
    out = np.zeros((len(q), 1 + len(bristles.reach)))
    for i in range(1, len(q)):
        out[i] = out[i - 1]
        bend_on(out[i], q[i] - q[i - 1], bristles)
    return out
