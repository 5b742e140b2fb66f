"""Drift: the zero of the torque sensor moves, whatever the motion.

As many of the slowest waves as it takes: four hold nineteen twentieths of an offset, and would take it with them. They
are zero when the recording starts. What a sensor drifted before is a constant in the log, as an offset is.
"""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, duration
from friction_audit.effects.terms.torque_drift import TERM, WAVES
from friction_audit.joint_log import Float

COUNT = "drift_waves"
SHORTEST_S = 30.0
"""Sensors drift with their temperature, within minutes: what changes within seconds is the motion's."""
CYCLES_PER_HALF_TURN = 2
"""A wave is slow that lasts longer than strokes do: else any misfit of the motion's own slow part passes for drift."""


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    length, found = duration(data), len(np.unique(data.cycle[data.used]))
    needed = CYCLES_PER_HALF_TURN * WAVES
    if length < SHORTEST_S or found < needed:
        return (
            f"{found} cycles in {length:.0f} s: a drift is told from slow motion over at least {needed} cycles and "
            f"{SHORTEST_S:g} s"
        )
    return both_directions(data, baseline)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either way."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=tuple({COUNT: float(waves)} for waves in range(1, WAVES + 1)),
    columns=columns_of(TERM),
    column_units=("nm",) * len(TERM.coefficients),
    untestable=untestable,
    admissible=admissible,
    axis="time",
    term=TERM,
)
