"""Bristles: any friction that builds up with the path since a reversal, as springs in parallel that slip.

A hysteresis that does not depend on the rate follows from the curve that it traces after a reversal from steady
sliding; springs with dry sliders (Maxwell slip) have any curve that rises ever more slowly, by as many straight pieces
as there are springs. The curve is asked of the term, whatever its formula.

Reference: F. Al-Bender, V. Lampaert, J. Swevers, The generalized Maxwell-slip model, IEEE Transactions on Automatic
Control 50 (2005) 1883.
"""

from dataclasses import dataclass

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.model.joint_model import FittedTerm
from friction_audit.model.term import Motion

PIECES = 12
"""Straight pieces of a curve."""
PATH_RAD = 0.4
"""Length of the stroke before and after the reversal: no bristle bends further."""
STEP_RAD = 1e-5
PROBE_RAD_S = 1e-3
"""So slow that what depends on the rate is nothing."""
LEAST_SHARE = 1e-6
"""A spring that bears less of the torque is none."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Bristles:
    """Springs in parallel, k of them.

    Attributes:
        stiffness: Shape (k,). [N m/rad]
        reach: Deflection at which each slips, shape (k,). [rad]
    """

    stiffness: Float
    reach: Float

    def along(self, q: Float) -> Float:
        """Deflections along a motion that begins with all at zero, shape (n, k). [rad]"""
        return np.asarray(_follow(np.ascontiguousarray(q), self.reach))

    def torque_along(self, q: Float) -> Float:
        """Torque along a motion, shape (n,). [N m]"""
        if not len(self.reach):
            return np.zeros(len(q))
        return np.asarray(self.along(q) @ self.stiffness)


NO_BRISTLES = Bristles(stiffness=np.zeros(0), reach=np.zeros(0))


def bristles_of(term: FittedTerm) -> tuple[float, Bristles]:
    """Ask a term for its curve after a reversal, and find the springs that have it.

    Returns:
        Dry friction that the term adds to that of the joint, below zero where bristles take its place [N m]; the
        springs.
    """
    torque, steps = _reversal(term)
    # At the reversal the direction jumps at once, the bristles do not; the first sample behind it is a step further.
    dry = -0.5 * (2.0 * torque[1] - torque[2] - torque[0])
    built = np.maximum.accumulate(np.append(0.0, torque[0] - dry - (torque[1:] + dry)))
    path = STEP_RAD * np.arange(steps + 1)
    wanted = built[-1] * np.arange(1, PIECES + 1) / PIECES
    knots = np.append(0, np.searchsorted(built, wanted * (1.0 - 1e-9)))
    knots = np.unique(np.minimum(knots, steps))
    slopes = np.append(np.diff(built[knots]) / np.diff(path[knots]), 0.0)
    stiffness, reach = np.maximum(-np.diff(slopes), 0.0), 0.5 * path[knots[1:]]
    bears = stiffness * reach > LEAST_SHARE * built[-1]
    return float(dry), Bristles(stiffness=stiffness[bears], reach=reach[bears])


def _reversal(term: FittedTerm) -> tuple[Float, int]:
    """Torque just before the reversal of a long stroke and at every step behind it, shape (1 + steps,). [N m]"""
    steps = round(PATH_RAD / STEP_RAD)
    there = STEP_RAD * np.arange(steps + 1)
    q = np.concatenate([there, there[-2::-1]])
    still = np.zeros(len(q))
    dq = np.where(np.arange(len(q)) <= steps, PROBE_RAD_S, -PROBE_RAD_S)
    t = np.asarray(np.arange(len(q)) * (STEP_RAD / PROBE_RAD_S), np.float64)
    torque = term.torque(Motion(t=t, q=q, dq=dq, ddq=still, rest=still))
    return np.asarray(torque[steps:]), steps


@compiled()
def _follow(q: Float, reach: Float) -> Float:
    """Deflections of sliding springs along a motion, shape (n, k)."""
    out = np.zeros((len(q), len(reach)))
    for i in range(1, len(q)):
        for k in range(len(reach)):
            out[i, k] = min(reach[k], max(-reach[k], out[i - 1, k] + q[i] - q[i - 1]))
    return out
