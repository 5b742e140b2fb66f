"""Unlogged compensation: a friction compensator that is not in the log helps the motion, less at low speed.

Smooth compensators hold back below a speed w, as tanh(dq / w), others have a dead band; that of C. Gaz et al., Dynamic
identification of the Franka Emika Panda robot, RA-L 4 (2019) 4147, is a sigmoid shifted through the origin.

Only stated friction can be missing: where Coulomb friction is fitted, less of it is all that a compensator leaves in
addition to a rise towards rest, which is Stribeck's.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, speeds
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

SMOOTH, DEAD_BAND = 0, 1
NOT_DECLARED = (
    "the friction was fitted to this log, and a compensator makes it less: state Coulomb friction (--joint-model with "
    'held = ["coulomb"]), or log the commanded torque'
)
WIDTHS = 6
LOWEST, HIGHEST = 0.01, 0.4  # shares of the log's high speed below which a compensator may hold back
SKEWS = (-0.3, 0.0, 0.3)


class UnloggedCompensation(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return what the joint then takes less, -tanh(dq / w + k) + tanh(k) or -sgn(dq) beyond a dead band."""
        width, skew, form = values
        speed = motion.dq / width
        if round(form) == DEAD_BAND:
            return -(np.sign(speed) * (np.abs(speed) > 1.0))[:, None]
        return np.asarray(np.tanh(skew) - np.tanh(speed + skew))[:, None]

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Widths by the speeds of the log; smooth ones with some skew."""
        (fast,) = speeds(data, 95.0)
        widths = np.clip(np.geomspace(LOWEST * fast, HIGHEST * fast, WIDTHS), *self.bounds("unlogged_width_rad_s"))
        forms = (*((skew, SMOOTH) for skew in SKEWS), (0.0, DEAD_BAND))
        return tuple(
            {"unlogged_width_rad_s": float(width), "unlogged_skew": skew, "unlogged_form": float(form)}
            for width in widths
            for skew, form in forms
        )

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        """The numbers or the motion that are lacking."""
        return both_directions(data, nominal) if "coulomb_nm" in nominal.declared else NOT_DECLARED


EFFECT = UnloggedCompensation(
    name="unlogged_compensation",
    label="less friction than stated: an unlogged compensator",
    family="slow and events",
    axis="speed",
    coefficients=(Parameter("unlogged_nm", "N m", "compensator torque at high speed", lower=0.0),),
    nonlinear=(
        Parameter("unlogged_width_rad_s", "rad/s", "velocity scale near zero", lower=1e-4, upper=10.0),
        Parameter("unlogged_skew", "1", "shift of its sigmoid", lower=-2.0, upper=2.0),
        Parameter("unlogged_form", "1", "0 smooth, 1 dead band", lower=0.0, upper=1.0, whole=True),
    ),
    traits=Trait.SPEED_ONLY,
    record="log the commanded torque",
)
