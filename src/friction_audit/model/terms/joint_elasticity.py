"""Joint elasticity: a spring between the side that is measured and the side that rubs.

The regressor is built for one stiffness and given per compliance: what the spring adds to the torque grows with the
compliance as long as the joint rings faster than it is moved, and no longer does where it rings with the motion.
"""

from collections.abc import Iterator, Sequence

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term
from friction_audit.model.transmission import Transmission, added_torques, far_side, part_of

DAMPING_RATIO = 0.05
"""Strain-wave gears damp little: a few hundredths (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996)."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what the spring adds to the torque per compliance, as a column."""
    ((_, column),) = bases(motion, [shape])
    return column


def bases(motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield the same for many shapes, behind which is one inertia."""
    yield from per_compliance(motion, [(stiffness, soft, DAMPING_RATIO) for stiffness, soft in shapes])


def per_compliance(
    motion: Motion, springs: Sequence[tuple[float, float, float]], share: float = 1.0
) -> Iterator[tuple[int, Float]]:
    """Yield the same for many springs: stiffness [N m/rad], soft torque [N m] and damping ratio of each.

    Behind them is this share of the inertia, and all friction.
    """
    links = [
        Transmission(stiffness_nm_per_rad=stiffness, damping_ratio=damping_ratio, soft_nm=soft)
        for stiffness, soft, damping_ratio in springs
    ]
    for place, added in added_torques(motion, part_of(far_side(motion), share), links):
        yield place, links[place].stiffness_nm_per_rad * added[:, None]


TERM = Term(
    name="joint_elasticity",
    label="a spring between motor and link",
    linear=(
        Parameter(name="compliance_rad_per_nm", unit="rad/(N m)", meaning="twist per torque", lower=0.0, upper=1.0),
    ),
    shape=(
        Parameter(
            name="spring_nm_per_rad",
            unit="N m/rad",
            meaning="stiffness that the ringing is built for",
            lower=1.0,
            upper=1e6,
        ),
        Parameter(name="soft_nm", unit="N m", meaning="torque up to which it is half as stiff", lower=0.0, upper=1e3),
    ),
    basis=basis,
    bases=bases,
    forward="spring",
)
