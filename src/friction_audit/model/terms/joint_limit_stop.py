"""Stops near the ends of the range: springs that only push back, with a damper while they are touched.

K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of Applied
Mechanics 42 (1975) 440: the torque grows with a power of the depth, and so does the damping; a plain damper besides.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term

DEPTH_RAD = 0.1
"""Depth at which a stop's torque is quoted, so that its unit does not depend on the exponent."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return (depth / 0.1 rad)^n at the upper and at the lower stop; dq while one is touched, and that times the power.

    Four columns.
    """
    upper, lower, exponent = shape
    above, below = np.maximum(motion.q - upper, 0.0), np.maximum(lower - motion.q, 0.0)
    touched = motion.dq * ((above > 0.0) | (below > 0.0))
    upper_power, lower_power = _power(above / DEPTH_RAD, exponent), _power(below / DEPTH_RAD, exponent)
    return np.stack([upper_power, -lower_power, touched, motion.dq * (upper_power + lower_power)]).T


def _power(depth: Float, exponent: float) -> Float:
    """Return a power of depths, most of which are zero, whose powers are too, and need no computing."""
    return np.asarray(np.power(depth, exponent, out=np.zeros_like(depth), where=depth > 0.0))


TERM = Term(
    name="joint_limit_stop",
    label="a stop near the end of the range",
    linear=(
        Parameter(name="stop_upper_nm", unit="N m", meaning="torque 0.1 rad into the upper stop", lower=0.0),
        Parameter(name="stop_lower_nm", unit="N m", meaning="torque 0.1 rad into the lower stop", lower=0.0),
        Parameter(name="stop_damping_nms_per_rad", unit="N m s/rad", meaning="damping while one is touched"),
        Parameter(name="stop_deep_damping_nms_per_rad", unit="N m s/rad", meaning="damping 0.1 rad into a stop"),
    ),
    shape=(
        Parameter(name="stop_upper_rad", unit="rad", meaning="where the upper stop begins"),
        Parameter(name="stop_lower_rad", unit="rad", meaning="where the lower stop begins"),
        Parameter(name="stop_exponent", unit="1", meaning="exponent of the depth", lower=0.5, upper=5.0),
    ),
    basis=basis,
)
