"""A cable or hose that pulls the joint back: a spring with a free stretch, linear and cubic, and its preload.

The free stretch makes it the slack of a cable; where it covers one end of the range, a tether that pulls at the other.
A linear spring about another centre is one about this centre with a preload.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import JointData, Nominal, reach
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

PARTS = 12  # of the range, between which it may begin to pull; the first and the last for a side on which it does not
# Free stretches are so many parts long: their middles lie closer to each other than their lengths. From no free
# stretch there is no way downhill to a short one, which therefore has to be on the grid.
STEP = 2
NONE = 1e-4  # half of a free stretch that is none to speak of, as a share of the range
# A spring without a free stretch that does not harden: nothing but stiffness and preload, wherever its centre is.
STRAIGHT: Nonlinear = {}


class CableSpring(Effect):
    indistinguishable = ("joint_limit_stop",)

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the stretch d = q - c less what is free of it, and its cube, and ones, as columns."""
        centre, free = values
        off = motion.q - centre
        stretch = np.sign(off) * np.maximum(np.abs(off) - free, 0.0)
        # Written out, for a power in general takes ten times as long.
        return np.stack([stretch, stretch * stretch * stretch, np.ones(len(off))]).T

    def regressor(self, data: JointData, nominal: Nominal, at: Nonlinear) -> Float:
        """Those of the term; of the straight spring position and preload only."""
        if at:
            return super().regressor(data, nominal, at)
        return np.column_stack([data.q, np.zeros(len(data.q)), np.ones(len(data.q))])

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """No free stretch, then all between edges but the one that leaves nothing, and the straight spring."""
        low, high = reach(data)
        # Whole numbers, for neighbours on a grid must not differ by rounding only.
        pairs = [(a, b) for a in range(PARTS) for b in range(a + STEP, PARTS + 1, STEP) if b - a < PARTS]
        places = [(PARTS, NONE), *((a + b, 0.5 * (b - a) / PARTS) for a, b in pairs)]
        bent = (
            {"cable_centre_rad": low + 0.5 * twice / PARTS * (high - low), "cable_free_rad": free * (high - low)}
            for twice, free in places
        )
        return (*bent, STRAIGHT)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return span(data, nominal, 0.8)

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """It pulls back from the beginning, and still when it is stretched by a radian."""
        return bool(coefficients[0] > 0 and coefficients[0] + coefficients[1] > 0)


EFFECT = CableSpring(
    name="cable_spring",
    label="a cable pulls the joint back",
    family="load and place",
    axis="position",
    coefficients=(
        Parameter("cable_stiffness_nm_per_rad", "N m/rad", "stiffness", lower=0.0),
        Parameter("cable_hardening_nm_per_rad3", "N m/rad^3", "cubic stiffness"),
        Parameter("cable_preload_nm", "N m", "preload"),
    ),
    nonlinear=(
        Parameter("cable_centre_rad", "rad", "neutral position"),
        Parameter("cable_free_rad", "rad", "slack to either side", lower=0.0),
    ),
    traits=Trait.EVEN,
    record="move through all of the range",
    separate={
        "joint_limit_stop": "move through all of the range: a stop is there at its ends only",
        "torque_bias": "rest at both ends of the range: a bias is the same there",
        "inertia_error": "move at two frequencies: on one sinusoid a spring and inertia are the same",
    },
)
