"""Joint elasticity: a spring between the side that is measured and the side that rubs.

The regressor is built for one stiffness and given per compliance: what the spring adds to the torque grows with the
compliance as long as the joint rings faster than it is moved, and no longer does where it rings with the motion.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import FarSide, Transmission, added_torques, far_side
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.effects.transmission import FAR_SHARE
from friction_audit.joint_log import Float

DAMPING_RATIO = 0.05
"""Strain-wave gears damp little: a few hundredths (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996)."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what the spring adds to the torque per compliance, as a column."""
    ((_, column),) = bases(motion, [shape])
    return column


def bases(motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield the same for many shapes, behind which is one inertia."""
    for place, added in springs(motion, [far_side(motion)] * len(shapes), shapes):
        yield place, np.multiply(added, shapes[place][0], out=added)[:, None]


def springs(motion: Motion, far: Sequence[FarSide], shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield what springs add to the torque, each with what is behind it, shape (n,)."""
    links = [
        Transmission(stiffness_nm_per_rad=stiffness, damping_ratio=damping_ratio, soft_nm=soft, far_share=share)
        for stiffness, soft, damping_ratio, share in shapes
    ]
    yield from added_torques(motion, far, links)


TERM = Term(
    name="joint_elasticity",
    label="a spring between motor and link",
    coefficients=(
        Parameter(name="compliance_rad_per_nm", unit="rad/(N m)", meaning="twist per torque", lower=0.0, upper=1.0),
    ),
    nonlinear=(
        Parameter(
            name="spring_nm_per_rad",
            unit="N m/rad",
            meaning="stiffness that the ringing is built for",
            lower=1.0,
            upper=1e6,
        ),
        Parameter(
            name="soft_nm",
            unit="N m",
            meaning="torque up to which it stiffens, half as stiff without any",
            lower=0.0,
            upper=1e3,
            optional=True,
        ),
        Parameter(
            name="damping_ratio",
            unit="1",
            meaning="damping ratio of the ringing, the measured side held",
            lower=0.0,
            upper=2.0,
            optional=True,
            default=DAMPING_RATIO,
        ),
        FAR_SHARE,
    ),
    basis=basis,
    bases=bases,
    forward="spring",
)
