"""Step of friction: s H, v H at the border of a cycle."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

FEWEST_CYCLES = 8


def step_at(data: JointData, share: float) -> Float:
    """1 from the cycle on that lies at that share of all cycles, shape (n,)."""
    cycles = np.unique(data.cycle[data.cycle >= 0])
    if len(cycles) == 0:
        return np.zeros(len(data.t))
    first = cycles[min(int(share * len(cycles)), len(cycles) - 1)]
    start = int(np.flatnonzero(data.cycle == first)[0])
    return (np.arange(len(data.t)) >= start).astype(float)


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Step of friction, shape (n, p)."""
    later = step_at(data, shape["share"])
    return np.column_stack([direction(data) * later, data.dq * later])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    found = len(np.unique(data.cycle[data.used]))
    if found < FEWEST_CYCLES:
        return f"{found} cycles: record at least {FEWEST_CYCLES}, 4 on either side of the change"
    return both_directions(data, baseline)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="friction_step",
    label="friction changes at one moment",
    shapes=tuple({"share": k / 24} for k in range(2, 23)),
    columns=columns,
    column_units=("nm", "nms_per_rad"),
    untestable=untestable,
    admissible=admissible,
    axis="time",
)
