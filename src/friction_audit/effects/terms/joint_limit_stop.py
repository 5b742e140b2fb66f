"""Stops near the ends of the range: springs that only push back, with a damper while they are touched.

K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of Applied
Mechanics 42 (1975) 440: the torque grows with a power of the depth, and so does the damping; a plain damper besides.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float, read_only

DEPTH_RAD = 0.1
"""Depth at which a stop's torque is quoted, so that its unit does not depend on the exponent."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return (depth / 0.1 rad)^n at the upper and at the lower stop; dq while one is touched, and that times the power.

    Four columns.
    """
    upper, lower, exponent = shape
    columns = np.zeros((4, len(motion.q)))
    _press(read_only(motion.q), read_only(motion.dq), float(upper), float(lower), float(exponent), columns)
    return columns.T


@compiled()
def _press(q: Float, dq: Float, upper: float, lower: float, exponent: float, columns: Float) -> None:
    """Fill columns (4, n) where a stop is touched; at most samples none is, and they stay zero."""
    for i in range(len(q)):
        above, below = max(q[i] - upper, 0.0), max(lower - q[i], 0.0)
        if above > 0.0 or below > 0.0:
            up = (above / DEPTH_RAD) ** exponent if above > 0.0 else 0.0
            down = (below / DEPTH_RAD) ** exponent if below > 0.0 else 0.0
            columns[0, i], columns[1, i], columns[2, i], columns[3, i] = up, -down, dq[i], dq[i] * (up + down)


TERM = Term(
    name="joint_limit_stop",
    label="a stop near the end of the range",
    coefficients=(
        Parameter(name="stop_upper_nm", unit="N m", meaning="torque 0.1 rad into the upper stop", lower=0.0),
        Parameter(name="stop_lower_nm", unit="N m", meaning="torque 0.1 rad into the lower stop", lower=0.0),
        Parameter(name="stop_damping_nms_per_rad", unit="N m s/rad", meaning="damping while one is touched"),
        Parameter(name="stop_deep_damping_nms_per_rad", unit="N m s/rad", meaning="damping 0.1 rad into a stop"),
    ),
    nonlinear=(
        Parameter(name="stop_upper_rad", unit="rad", meaning="where the upper stop begins"),
        Parameter(name="stop_lower_rad", unit="rad", meaning="where the lower stop begins"),
        Parameter(name="stop_exponent", unit="1", meaning="exponent of the depth", lower=0.5, upper=5.0),
    ),
    basis=basis,
)
