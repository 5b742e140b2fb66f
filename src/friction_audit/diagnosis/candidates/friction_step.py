"""Step of friction: Coulomb and viscous friction change at one moment."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, duration
from friction_audit.effects.terms.friction_step import TERM
from friction_audit.joint_log import Float

FEWEST_CYCLES = 8
MOMENTS = 32
AT_ONCE = 1e-5
"""Length of a step, as a share of the log's: less than a sample."""
RAMPS = 16
"""Neighbours overlap by half, for from a step there is no way downhill to a ramp that lies between two."""
LENGTH = 0.12
"""How long a ramp takes, as a share of the log's length; a ramp of the whole log would be a warm-up."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Steps from a sixteenth of the log on, and ramps."""
    length = duration(data)
    steps = [(k / MOMENTS, AT_ONCE) for k in range(2, MOMENTS - 1)]
    ramps = [(k / RAMPS, LENGTH) for k in range(1, RAMPS)]
    return tuple(
        {"step_time_s": float(data.t[0]) + share * length, "step_length_s": part * length}
        for share, part in (*steps, *ramps)
    )


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    found = len(np.unique(data.cycle[data.used]))
    if found < FEWEST_CYCLES:
        return f"{found} cycles: record at least {FEWEST_CYCLES}, 4 on either side of the change"
    return both_directions(data, baseline)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """More or less friction than before."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm", "nms_per_rad"),
    untestable=untestable,
    admissible=admissible,
    axis="time",
    term=TERM,
    moment="step_time_s",
)
