"""Elasticity: a spring between what is measured and what rubs."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import reversals
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.joint_elasticity import TERM

STIFFNESSES_NM_PER_RAD = np.geomspace(10.0, 1e5, 25)
"""From a rubber band to a steel shaft."""
SOFT_SHARES = (1e-3, 0.3, 1.0, 3.0)
"""Torque up to which a strain-wave gear is soft, as a share of the usual torque; the first is a linear spring."""
LARGEST_SHARE = 1.6
FEWEST_REVERSALS = 20
LEAST_SHARE = 0.5
"""Compliance found times the stiffness it was built for; a stiffer spring than the stiffest looks just like it."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Linear springs of all stiffnesses, and of every other one springs that are soft at first."""
    usual = float(np.sqrt(np.mean(data.torque**2))) or 1.0
    return tuple(
        {"spring_nm_per_rad": float(stiffness), "soft_nm": share * usual}
        for k, share in enumerate(SOFT_SHARES)
        for stiffness in STIFFNESSES_NM_PER_RAD[:: 2 if k else 1]
    )


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking: jumps of friction show it, at equally fast strokes too."""
    return reversals(data, baseline, FEWEST_REVERSALS)


def admissible(factors: Float, shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    share = factors[0] * shape["spring_nm_per_rad"]
    least = 0.0 if shape["spring_nm_per_rad"] >= STIFFNESSES_NM_PER_RAD[-1] else LEAST_SHARE
    return bool(least < share <= LARGEST_SHARE)


CANDIDATE = Candidate(
    name="joint_elasticity",
    label="a spring between motor and link",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("rad_per_nm",),
    untestable=untestable,
    admissible=admissible,
    axis="acceleration",
    term=TERM,
    leans_on_model=True,
)
