"""Stribeck friction: more friction at low speed, which fades as the lubricant's film builds up.

Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, eq. (5): the excess falls as
exp(-|dq / v_s|^delta).
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import speed_range
from friction_audit.effects.joint_data import JointData, Nominal, speeds
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

SPEEDS = 8
EXPONENTS = (0.5, 1.0, 2.0)
# Shares of the log's high speed between which friction may fade: beyond, no film has built up within the log.
LOWEST, HIGHEST = 0.01, 0.4


class Stribeck(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) exp(-|dq / v_s|^delta) as a column."""
        speed, exponent = values
        fading = np.exp(-(np.abs(motion.dq / speed) ** exponent))
        return np.asarray(motion.direction * fading)[:, None]

    def in_cpp(self, values: Sequence[float], table: str) -> str:
        excess, speed, exponent = values
        return f"{excess!r} * way * std::exp(-std::pow(pace / {speed!r}, {exponent!r}))"

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Stribeck velocities by the speeds of the log, each with the exponents."""
        (fast,) = speeds(data, 95.0)
        fading = np.clip(np.geomspace(LOWEST * fast, HIGHEST * fast, SPEEDS), *self.bounds("stribeck_speed_rad_s"))
        return tuple({"stribeck_speed_rad_s": float(v), "stribeck_exponent": d} for v in fading for d in EXPONENTS)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return speed_range(data, nominal, 8.0)


EFFECT = Stribeck(
    name="stribeck",
    label="more friction at low speed",
    family="velocity",
    axis="speed",
    coefficients=(Parameter("stribeck_excess_nm", "N m", "static minus Coulomb friction", lower=0.0),),
    nonlinear=(
        Parameter("stribeck_speed_rad_s", "rad/s", "Stribeck velocity", lower=1e-6, upper=10.0),
        Parameter("stribeck_exponent", "1", "Stribeck exponent", lower=0.2, upper=5.0),
    ),
    traits=Trait.FRICTION | Trait.SPEED_ONLY,
    record="move steadily at speeds that differ by a factor of 8, very slow to fast",
    separate={
        "nonlinear_viscous": "move steadily at speeds that differ by a factor of 8 and more, very slow to fast",
        "presliding": "reverse slowly and fast at the same places: presliding goes by the path, not the speed",
        "stiction": "start slowly and go on slowly for some seconds: stiction is over once the joint moves",
        "frictional_lag": "move slowly at constant speed: without acceleration there is no lag",
        "unlogged_compensation": "log the commanded torque, or record again without compensation",
        "torque_ripple": "pass slowly and steadily over five periods of the ripple in both directions",
    },
)
