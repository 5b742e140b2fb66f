"""The proof that a simulated motion is one: finite, and no faster or stronger than a joint can be."""

import numpy as np

from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.simulate.simulation import Motion

FASTEST_RAD_S = 1e3
"""No joint of an arm turns a hundredth as fast. [rad/s]"""

STRONGEST_NM = 1e6
"""No joint of an arm holds a thousandth of it. [N m]"""

ADVICE = "set masses, stiffnesses and torques closer to those of a joint, or leave the effect out"


def require_sane(motion: Motion, path: str) -> Motion:
    """Return a motion that did not diverge.

    Raises:
        AnalysisError: If a velocity or a torque is not finite or beyond all joints; at the first such instant.
    """
    speeds = (motion.dq, motion.inner_dq)
    torques = (motion.port_nm, motion.support_nm, motion.friction_nm, motion.compensation_nm, motion.passivity_nm)
    _require(speeds, FASTEST_RAD_S, "speed", "rad/s", motion.t, path)
    _require(torques, STRONGEST_NM, "torque", "N m", motion.t, path)
    return motion


def _require(signals: tuple[Float, ...], limit: float, what: str, unit: str, t: Float, path: str) -> None:
    """Refuse what is not finite or above the limit; written so that NaN, which compares as false, is caught."""
    if all(-limit <= signal.min() and signal.max() <= limit for signal in signals):
        return
    bad = np.array([~(np.abs(signal) <= limit) for signal in signals])
    _, ticks, joints = np.nonzero(bad)
    first = ticks.argmin()
    joint, instant = joints[first] + 1, t[ticks[first]]
    raise AnalysisError(
        f"{path}: the simulation diverged: joint {joint} has a {what} above {limit:g} {unit} at {instant:.3f} s, or "
        f"none that is a number; nothing was written; {ADVICE}"
    )
