"""A torque that is late by less than half a sample of the log: the recorder's doing, not the joint's.

A sensor that is read when the recorder comes by, or whose last value is repeated where none came, gives a torque that
is half a sample old on average, or less. Beside sharp reversals a fraction of a millisecond is plain in a log. It is no
effect of the joint: the torque is put on time, and the joint is judged anew.
"""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.discrepancy.candidates.time_delay import CANDIDATE as TIME_DELAY
from friction_audit.discrepancy.data_audit import DataFinding
from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.naming import Names

MOST_SAMPLES = 0.5
"""What the age of the last value of a sensor is on average, in samples of the log."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class PutOnTime:
    """A joint whose torque was read late, put on time, and what is told of it."""

    data: JointData
    finding: DataFinding


def put_on_time(ground: Ground, names: Names) -> PutOnTime | None:
    """Take a delay that is too short to be the joint's out of the torque.

    Args:
        ground: The joint.
        names: What it misses.

    Returns:
        The same joint on time, in which no such delay is sought again; None where there is none.
    """
    late = next((k for k, f in enumerate(names.found) if f.candidate.name == TIME_DELAY.name), None)
    if late is None:
        return None
    found = names.found[late]
    before = ground.base.shape[1] + sum(f.columns.shape[1] for f in names.found[:late])
    factors = least_squares(np.hstack([ground.base, *(f.columns for f in names.found)]), ground.y)
    factors = factors[before : before + found.columns.shape[1]]
    delay_s, bound_s = float(factors[0]), MOST_SAMPLES * ground.data.sample_s
    if abs(delay_s) >= bound_s:
        return None
    torque = found.candidate.columns(ground.data, names.baseline, found.shape) @ factors
    return PutOnTime(
        data=replace(ground.data, torque=ground.data.torque - torque, sample_s=0.0),
        finding=DataFinding(code="torque_delay", value=delay_s, unit="s", bound=bound_s, verdict="fine", message=""),
    )
