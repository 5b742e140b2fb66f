"""Coulomb friction that depends on the position: a wave over the whole range, or over a stretch of it.

B. Armstrong-Helouvry, Control of Machines with Friction, 1991, section 4.4: friction of geared joints repeats with the
position. A wave under a bell is a patch where the bell is narrower than the wave is long.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import both_directions, span
from friction_audit.effects.joint_data import JointData, Nominal, reach
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

WAVES = 10
PATCHES = (8, 16)  # half widths of patches, as how many of them the range takes
ORDER, CENTRE, WIDTH = "position_friction_order", "position_friction_centre_rad", "position_friction_width_rad"
EVERYWHERE = 1e6  # width of a bell that does not matter


class PositionDependentFriction(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) exp(-((q - c) / w)^2 / 2) times cos and sin of k (q - c), two columns."""
        order, centre, width = values
        off = motion.q - centre
        bell = motion.direction * np.exp(-0.5 * (off / width) ** 2)
        return np.stack([bell * np.cos(order * off), bell * np.sin(order * off)]).T

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Waves from half a period over the range on, half a period apart; patches a width and a half apart.

        A patch is a bell, three numbers for a log of few cycles (measured TX40, joint 4), or a wave under a bell.
        """
        low, high = reach(data)
        length = max(high - low, 1e-3)
        waves = [{ORDER: float(np.pi / length * k)} for k in range(1, WAVES + 1)]
        bells = [
            {CENTRE: float(low + (k + 0.5) * 1.5 * length / parts), WIDTH: float(length / parts)}
            for parts in PATCHES
            for k in range(int(parts / 1.5))
        ]
        return (*waves, *bells, *({ORDER: 1.0 / bell[WIDTH], **bell} for bell in bells))

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return both_directions(data, nominal) or span(data, nominal, 0.5)


EFFECT = PositionDependentFriction(
    name="position_dependent_friction",
    label="friction changes with position",
    family="load and place",
    axis="position",
    coefficients=(
        Parameter("position_friction_cos_nm", "N m", "cosine amplitude"),
        Parameter("position_friction_sin_nm", "N m", "sine amplitude"),
    ),
    nonlinear=(
        Parameter(ORDER, "1", "waves per revolution", lower=0.0, upper=1e4, optional=True),
        Parameter(CENTRE, "rad", "centre of the stretch", optional=True),
        Parameter(WIDTH, "rad", "half width of the stretch", lower=1e-4, default=EVERYWHERE, optional=True),
    ),
    traits=Trait.FRICTION,
    record="pass every place four times in each direction",
    separate={
        "torque_ripple": "pass every place four times in each direction",
        "gravity_error": "pass every place four times in each direction",
    },
)
