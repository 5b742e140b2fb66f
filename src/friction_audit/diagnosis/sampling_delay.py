"""A torque, or friction alone, that is off by a part of a sample of the log: the recorder's doing, not the joint's.

A sensor that is read when the recorder comes by, or whose last value is repeated where none came, gives a torque that
is half a sample old on average, or less. Beside sharp reversals a fraction of a millisecond is plain in a log. It is no
effect of the joint: the torque is put on time, and the joint is judged anew.

So is the moment at which friction turns. A position is as old as a torque may be, and a joint whose motor turns it
around rests until the motor has turned its torque, for a millisecond that no velocity shows behind a low-pass. With a
good sensor that is far above the noise, and would get the name of friction that builds up over some microradians.
"""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.confirmation import evidence
from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Names
from friction_audit.diagnosis.ranking import BY_CHANCE
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.presliding import EFFECT as PRESLIDING
from friction_audit.effects.time_delay import EFFECT as TIME_DELAY
from friction_audit.joint_log import Float

MOST_SAMPLES = 0.5
"""What the age of the last value of a sensor is on average, in samples of the log."""
MOST_TURN_SAMPLES = 1.0
"""The same of a torque beside a position."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class PutOnTime:
    """A joint put on time, and what is told of it."""

    data: JointData
    finding: DataFinding


def put_on_time(ground: Ground, names: Names) -> PutOnTime | None:
    """Take what is off by too little to be the joint's out of the torque.

    Args:
        ground: The joint.
        names: What it misses.

    Returns:
        The same joint on time, in which nothing of the kind is sought again; None where there is none.
    """
    late = _late_torque(ground, names)
    return _late_turns(ground, names) if late is None else late


def _late_torque(ground: Ground, names: Names) -> PutOnTime | None:
    """A delay of the torque."""
    late = next((k for k, f in enumerate(names.found) if f.candidate.name == TIME_DELAY.name), None)
    if late is None:
        return None
    found = names.found[late]
    before = ground.base.shape[1] + sum(f.columns.shape[1] for f in names.found[:late])
    factors = least_squares(np.hstack([ground.base, *(f.columns for f in names.found)]), ground.y)
    factors = factors[before : before + found.columns.shape[1]]
    torque = found.candidate.regressor(ground.data, names.baseline, found.shape) @ factors
    return _on_time(ground.data, torque, "torque_delay", float(factors[0]), MOST_SAMPLES)


def _late_turns(ground: Ground, names: Names) -> PutOnTime | None:
    """A delay of the moments at which friction turns, if presliding brings no more beside it than names by chance."""
    from scipy.special import chdtri

    own = next((f for f in names.found if f.candidate.name == PRESLIDING.name), None)
    if own is None:
        return None
    turns = -names.baseline.coulomb_nm * np.gradient(ground.data.way, ground.data.step_s)
    rest = [f.columns for f in names.found if f is not own]
    with_turns = [*rest, ground.rows.of(turns)[:, None]]
    told = evidence(ground, [*with_turns, own.columns])[-1]
    if told >= chdtri(own.columns.shape[1] + len(own.shape), BY_CHANCE / len(names.library.entries)):
        return None
    delay_s = float(least_squares(np.hstack([ground.base, *with_turns]), ground.y)[-1])
    return _on_time(ground.data, delay_s * turns, "friction_delay", delay_s, MOST_TURN_SAMPLES)


def _on_time(data: JointData, torque: Float, code: str, delay_s: float, most_samples: float) -> PutOnTime | None:
    """The joint without the torque of a delay; None where it is no part of a sample."""
    bound_s = most_samples * data.sample_s
    if abs(delay_s) >= bound_s:
        return None
    return PutOnTime(
        data=replace(data, torque=data.torque - torque, sample_s=0.0),
        finding=DataFinding(code=code, value=delay_s, unit="s", bound=bound_s, verdict="fine", message=""),
    )
