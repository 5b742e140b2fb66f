"""Whether a small effect may be what the formula of a larger one does not get right."""

DIRECTIONLESS = ("torque_bias", "torque_drift", "gravity_error", "cable_spring", "joint_limit_stop")
"""Torques of place or time: whatever their formulas miss does not turn with the direction either."""
TURNING = (
    "stribeck",
    "nonlinear_viscous",
    "presliding",
    "load_dependent_friction",
    "position_dependent_friction",
    "warm_up",
    "friction_step",
)
"""Friction: at the same place and time it is opposite in the other direction."""


def may_mend(small: str, large: str) -> bool:
    """Return whether the first effect may be what the second one's formula lacks.

    Args:
        small: Name of the smaller effect.
        large: Name of the larger one.
    """
    return not (small in TURNING and large in DIRECTIONLESS)
