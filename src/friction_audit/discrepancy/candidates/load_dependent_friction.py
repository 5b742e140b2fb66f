"""Load-dependent Coulomb friction: s |load| with the predicted load, never the measured one."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, baseline: Baseline, shape: Shape) -> Float:
    """Load-dependent Coulomb friction, shape (n, p)."""
    gravity = np.zeros(len(data.t)) if data.gravity is None else data.gravity
    return np.asarray(direction(data) * np.abs(gravity + shape["side"] * baseline.torque))[:, None]


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    lacking = both_directions(data, baseline)
    if lacking:
        return lacking
    if data.gravity is None:
        return "the load is not known: log gravity or name the arm, and carry different loads over the same motion"
    low, high = np.percentile(np.abs(data.gravity[data.used]), [5, 95])
    if high < 3.0 * max(low, 1e-9) or high < baseline.coulomb_nm:
        return "the load hardly varies: let it vary by a factor of 3, by posture or payload"
    return None


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(factors[0] > 0)


CANDIDATE = Candidate(
    name="load_dependent_friction",
    label="friction grows with load",
    shapes=({"side": -1.0}, {"side": 1.0}),
    columns=columns,
    column_units=("1",),
    untestable=untestable,
    admissible=admissible,
    axis="load",
)
