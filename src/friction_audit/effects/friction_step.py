"""Friction that changes once, at a moment of the recording, at once or within some seconds."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, duration
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

FEWEST_CYCLES = 8
MOMENTS = 32
AT_ONCE = 1e-5  # length of a step, as a share of the log's: less than a sample
RAMPS = 16  # neighbours overlap by half, for from a step there is no way downhill to a ramp that lies between two
LENGTH = 0.12  # how long a ramp takes, as a share of the log's length; a ramp of the whole log would be a warm-up


class FrictionStep(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) and dq times a ramp from 0 to 1 about a moment, as columns; a step where its length is 0."""
        moment, length = values
        later = motion.t - moment
        ramp = np.clip(0.5 + later / length, 0.0, 1.0) if length > 0.0 else (later >= 0.0).astype(np.float64)
        return np.stack([motion.direction * ramp, motion.dq * ramp]).T

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Steps from a sixteenth of the log on, and ramps."""
        length = duration(data)
        steps = [(k / MOMENTS, AT_ONCE) for k in range(2, MOMENTS - 1)]
        ramps = [(k / RAMPS, LENGTH) for k in range(1, RAMPS)]
        return tuple(
            {"step_time_s": float(data.t[0]) + share * length, "step_length_s": part * length}
            for share, part in (*steps, *ramps)
        )

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        found = len(np.unique(data.cycle[data.used]))
        if found < FEWEST_CYCLES:
            return f"{found} cycles: record at least {FEWEST_CYCLES}, 4 on either side of the change"
        return both_directions(data, nominal)


EFFECT = FrictionStep(
    name="friction_step",
    label="friction changes at one moment",
    family="slow and events",
    axis="time",
    coefficients=(
        Parameter("step_coulomb_nm", "N m", "change of Coulomb friction"),
        Parameter("step_viscous_nms_per_rad", "N m s/rad", "change of viscous friction"),
    ),
    nonlinear=(
        Parameter("step_time_s", "s", "time of the change"),
        Parameter("step_length_s", "s", "duration of the change", lower=0.0),
    ),
    traits=Trait.FRICTION,
    record="record at least 4 cycles before and after the change",
    separate={"contact_event": "record at least 4 cycles before and after the moment: a contact passes"},
)
