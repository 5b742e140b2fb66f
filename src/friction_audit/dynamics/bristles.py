"""Presliding friction of any term, as bristles: a Dahl model or a Maxwell-slip (Prandtl-Ishlinskii) model.

Both models are fitted to the reversal curve of the term: its torque over the displacement since a reversal from steady
sliding. They differ after shorter strokes. In the Dahl model, the slope depends on torque and direction only, so the
torque moves along the curve or its mirror image. The Maxwell-slip model has elasto-plastic elements in parallel, each
with a stiffness and a yield deflection; it remembers every reversal until a larger loop closes. Bristle damping is
proportional to the rate of the torque.

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

STROKE_RAD, STEP_RAD = 0.4, 1e-5  # stroke before and after the reversal, beyond every yield deflection; its grid
POINTS = 400  # points of a curve at even steps of the torque, and as many at even steps of log displacement
ELEMENTS = 24  # elements of the Maxwell-slip model
SMALLEST_SHARE = 1e-6  # an element with a smaller share of the torque is dropped
SLOW_RAD_S, FAST_RAD_S = 1e-3, 0.1  # speeds of the two reversals; their difference gives the damping


class Bristles(NamedTuple):
    """A Dahl curve of k points, or m Maxwell-slip elements."""

    path: Float  # displacement since a reversal to negative velocity, rising from 0, shape (k,) [rad]
    torque: Float  # friction torque there, falling, shape (k,) [N m]
    stiffness: Float  # stiffness of each element, shape (m,) [N m/rad]
    yield_rad: Float  # deflection at which the element slips, shape (m,) [rad]
    damping_s: float  # damping over stiffness [s]

    def states_along(self, q: Float) -> Float:
        """Return Dahl torque [N m] and deflections [rad] along a motion from a relaxed start, shape (n, 1 + m)."""
        return np.asarray(_integrate(read_only(q), self))

    def torque_along(self, q: Float) -> Float:
        """Return the torque without damping along a motion from a relaxed start, shape (n,). [N m]"""
        states = self.states_along(q)
        return np.asarray(states[:, 0] + states[:, 1:] @ self.stiffness)


NO_BRISTLES = Bristles(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), damping_s=0.0)


def fit_bristles(term: Term) -> tuple[float, Bristles, Bristles]:
    """Return the Coulomb friction of a term, negative where bristles replace it; its Dahl and Maxwell-slip models."""
    before, slow = _reversal_torque(term, SLOW_RAD_S)
    # Coulomb friction jumps at the reversal, bristles do not; the first sample is one step after it.
    dry = -0.5 * (2.0 * slow[0] - slow[1] - before)
    curve = np.minimum.accumulate(np.append(before - dry, slow + dry))
    path = np.asarray(STEP_RAD * np.arange(len(curve)), np.float64)
    rate = np.gradient(curve, STEP_RAD)[1:]
    more = _reversal_torque(term, FAST_RAD_S)[1] - slow
    square = float(rate[1:] @ rate[1:])
    damping = float(rate[1:] @ more[1:]) / square / (FAST_RAD_S - SLOW_RAD_S) if square > 0.0 else 0.0
    damped = NO_BRISTLES._replace(damping_s=max(damping, 0.0))
    # Points of the curve at even steps of the torque and of the logarithm of the displacement.
    last = len(curve) - 1
    heights = np.searchsorted(-curve, -np.linspace(curve[0], curve[-1], POINTS)).clip(max=last)
    chosen = np.unique(np.concatenate([[0], heights, np.rint(np.geomspace(1, last, POINTS)).astype(int)]))
    dahl = damped._replace(path=path[chosen], torque=curve[chosen])
    # The elements give the curve exactly at even steps of the torque; each yields after twice its yield deflection.
    built = curve[0] - curve
    knots = np.searchsorted(built, built[-1] * np.arange(1, ELEMENTS + 1) / ELEMENTS * (1.0 - 1e-9))
    knots = np.unique(np.append(0, np.minimum(knots, last)))
    slopes = np.append(np.diff(built[knots]) / np.diff(path[knots]), 0.0)
    stiffness, yield_rad = np.maximum(-np.diff(slopes), 0.0), 0.5 * path[knots[1:]]
    kept = stiffness * yield_rad > SMALLEST_SHARE * built[-1]
    return float(dry), dahl, damped._replace(stiffness=stiffness[kept], yield_rad=yield_rad[kept])


def _reversal_torque(term: Term, speed: float) -> tuple[float, Float]:
    """Return the torque just before the reversal of a long stroke, and at every step after it. [N m]"""
    steps = round(STROKE_RAD / STEP_RAD)
    there = STEP_RAD * np.arange(steps + 1)
    q = np.concatenate([there, there[-2::-1]])
    still = np.zeros(len(q))
    dq = np.where(np.arange(len(q)) <= steps, speed, -speed)
    t = np.asarray(np.arange(len(q)) * (STEP_RAD / speed), np.float64)
    torque = term.torque(Motion(t=t, q=q, dq=dq, ddq=still, rest=still))
    # A term may differentiate over the reversal; the last sample of steady sliding is the one before.
    return float(torque[steps - 2]), torque[steps + 1 :]


@compiled()
def dahl_torque(torque: float, displacement: float, bristles: Bristles) -> float:
    """Return the torque of the Dahl model after a signed displacement from a torque. [N m]"""
    path, curve = bristles.path, bristles.torque
    if len(path) == 0 or displacement == 0.0:
        return torque
    sign = -1.0 if displacement > 0.0 else 1.0
    low = _interval(sign * torque, curve)
    drop = curve[low] - curve[low + 1]
    share = min(1.0, max(0.0, (curve[low] - sign * torque) / drop)) if drop > 0.0 else 1.0
    on = path[low] + share * (path[low + 1] - path[low]) + abs(displacement)
    if on <= path[0] or on >= path[-1]:
        return float(sign * (curve[0] if on <= path[0] else curve[-1]))
    low = np.searchsorted(path, on) - 1
    share = (on - path[low]) / (path[low + 1] - path[low])
    return float(sign * (curve[low] + share * (curve[low + 1] - curve[low])))


@compiled(inline=True)
def _interval(torque: float, curve: Float) -> int:
    """Return the index of the interval of a falling curve that holds a torque."""
    low = len(curve) - 1 - int(np.searchsorted(curve[::-1], torque))
    return min(max(low, 0), len(curve) - 2)


@compiled(inline=True)
def bristle_nm(state: Float, displacement: float, bristles: Bristles) -> float:
    """Return the torque of the bristles after a displacement from their state, without damping. [N m]"""
    torque = dahl_torque(state[0], displacement, bristles)
    for k in range(len(bristles.yield_rad)):
        most = bristles.yield_rad[k]  # deflection of a Maxwell-slip element
        torque += bristles.stiffness[k] * min(most, max(-most, state[1 + k] + displacement))
    return torque


@compiled(inline=True)
def advance_bristles(state: Float, displacement: float, bristles: Bristles) -> None:
    """Move the state of the bristles on by a displacement, in place."""
    state[0] = dahl_torque(state[0], displacement, bristles)
    for k in range(len(bristles.yield_rad)):
        most = bristles.yield_rad[k]
        state[1 + k] = min(most, max(-most, state[1 + k] + displacement))


@compiled(inline=True)
def bristle_damping(state: Float, sign: float, bristles: Bristles) -> float:
    """Return the viscous coefficient of the bristles for a direction of motion. [N m s/rad]"""
    if bristles.damping_s == 0.0:
        return 0.0
    stiffness, path, curve = 0.0, bristles.path, bristles.torque
    if len(path) > 0:
        low = _interval(-sign * state[0], curve)
        stiffness = (curve[low] - curve[low + 1]) / (path[low + 1] - path[low])
    for k in range(len(bristles.yield_rad)):
        if state[1 + k] * sign < bristles.yield_rad[k]:
            stiffness += bristles.stiffness[k]
    return float(bristles.damping_s * stiffness)


@compiled()
def _integrate(q: Float, bristles: Bristles) -> Float:
    out = np.zeros((len(q), 1 + len(bristles.yield_rad)))
    for i in range(1, len(q)):
        out[i] = out[i - 1]
        advance_bristles(out[i], q[i] - q[i - 1], bristles)
    return out
