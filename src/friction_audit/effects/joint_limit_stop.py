"""Stops near the ends of the range: springs that only push back, with a damper while they are touched.

K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of Applied
Mechanics 42 (1975) 440: the torque grows with a power of the depth, and so does the damping; a plain damper too.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float, read_only

DEPTH_RAD = 0.1  # depth at which a stop's torque is quoted, so that its unit does not depend on the exponent
# How deep the joint goes into a stop, as shares of the range; 0 where it does not reach it.
DEPTHS = (0.0, 0.02, 0.05, 0.08, 0.12, 0.2)
EXPONENTS = (1.0, 2.0)


class JointLimitStop(Effect):
    indistinguishable = ("cable_spring",)

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return (depth / 0.1 rad)^n at the upper and the lower stop, dq while one is touched, that times the power.

        Four columns.
        """
        upper, lower, exponent = values
        columns = np.zeros((4, len(motion.q)))
        _press(read_only(motion.q), read_only(motion.dq), float(upper), float(lower), float(exponent), columns)
        return columns.T

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """One stop, or two equally deep, with the exponents."""
        low, high = float(data.q.min()), float(data.q.max())
        length = high - low
        alone = [(depth, 0.0) for depth in DEPTHS[1:]] + [(0.0, depth) for depth in DEPTHS[1:]]
        both = [(depth, depth) for depth in DEPTHS[1:]]
        return tuple(
            {"stop_upper_rad": high - up * length, "stop_lower_rad": low + down * length, "stop_exponent": exponent}
            for up, down in (*alone, *both)
            for exponent in EXPONENTS
        )

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return span(data, nominal, 0.5)

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """Stops push back."""
        return bool(coefficients[0] >= 0 and coefficients[1] >= 0 and coefficients[0] + coefficients[1] > 0)


@compiled()
def _press(q: Float, dq: Float, upper: float, lower: float, exponent: float, columns: Float) -> None:
    """Fill columns (4, n) where a stop is touched; at most samples none is, and they stay zero."""
    for i in range(len(q)):
        above, below = max(q[i] - upper, 0.0), max(lower - q[i], 0.0)
        if above > 0.0 or below > 0.0:
            up = (above / DEPTH_RAD) ** exponent if above > 0.0 else 0.0
            down = (below / DEPTH_RAD) ** exponent if below > 0.0 else 0.0
            columns[0, i], columns[1, i], columns[2, i], columns[3, i] = up, -down, dq[i], dq[i] * (up + down)


EFFECT = JointLimitStop(
    name="joint_limit_stop",
    label="a stop near the end of the range",
    family="load and place",
    axis="position",
    coefficients=(
        Parameter("stop_upper_nm", "N m", "torque 0.1 rad into the upper stop", lower=0.0),
        Parameter("stop_lower_nm", "N m", "torque 0.1 rad into the lower stop", lower=0.0),
        Parameter("stop_damping_nms_per_rad", "N m s/rad", "damping in contact"),
        Parameter("stop_deep_damping_nms_per_rad", "N m s/rad", "damping 0.1 rad into a stop"),
    ),
    nonlinear=(
        Parameter("stop_upper_rad", "rad", "position of the upper stop"),
        Parameter("stop_lower_rad", "rad", "position of the lower stop"),
        Parameter("stop_exponent", "1", "exponent of the depth", lower=0.5, upper=5.0),
    ),
    traits=Trait.EVEN,
    record="move through all of the range",
    separate={"contact_event": "go to the same place again: a stop is still there"},
)
