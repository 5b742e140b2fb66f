"""Backlash: play between the side that is measured and the side that rubs.

Where the torque changes sign the far side flies free, friction alone on it, until the measured side has crossed the
play and strikes it on the other flank.
"""

from collections.abc import Iterator, Sequence
from math import sqrt

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import (
    FarSide,
    Transmission,
    added_torques,
    far_side,
    flank_stiffness,
    part_of,
    simple_torque,
)
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.effects.transmission import FAR_SHARE
from friction_audit.joint_log import Float

CONTACT_DAMPING_RATIO = 0.2
"""Of metal on lubricated metal: half of the speed is left after an impact."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what play in front of the far side adds to the torque, as a column."""
    ((_, column),) = bases(motion, [shape])
    return column


def bases(motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield the same for many shapes, behind which is one inertia."""
    far, torque = far_side(motion), simple_torque(motion)
    usual = sqrt(torque @ torque / len(torque))
    yield from plays(motion, [far] * len(shapes), [usual] * len(shapes), shapes)


def plays(
    motion: Motion, far: Sequence[FarSide], usual_nm: Sequence[float], shapes: Sequence[Sequence[float]]
) -> Iterator[tuple[int, Float]]:
    """Yield the same for many shapes, each with what is behind it, and the usual torque of that."""
    flanks = [
        flank(part_of(own, shape[-1]).inertia_kg_m2, usual, shape)
        for own, usual, shape in zip(far, usual_nm, shapes, strict=True)
    ]
    for place, added in added_torques(motion, far, flanks):
        yield place, added[:, None]


def flank(inertia_kg_m2: float, usual_nm: float, shape: Sequence[float]) -> Transmission:
    """Return the transmission of a play.

    Args:
        inertia_kg_m2: Inertia behind it.
        usual_nm: Root mean square of the torque that it transmits.
        shape: Values of the term's shape.
    """
    gap, contact_hz, damping_ratio, share = shape
    return Transmission(
        stiffness_nm_per_rad=flank_stiffness(inertia_kg_m2, contact_hz, gap, usual_nm),
        damping_ratio=damping_ratio,
        gap_rad=gap,
        far_share=share,
    )


TERM = Term(
    name="backlash",
    label="free play between motor and link",
    coefficients=(
        Parameter(
            name="backlash_share",
            unit="1",
            meaning="share of inertia and friction behind the play",
            lower=0.0,
            upper=1.5,
        ),
    ),
    nonlinear=(
        Parameter(name="gap_rad", unit="rad", meaning="full width of the play", lower=1e-7, upper=1.0),
        Parameter(name="contact_hz", unit="Hz", meaning="ringing on a flank that touches", lower=1.0, upper=1e3),
        Parameter(
            name="flank_damping_ratio",
            unit="1",
            meaning="damping ratio of that ringing",
            lower=0.0,
            upper=2.0,
            optional=True,
            default=CONTACT_DAMPING_RATIO,
        ),
        FAR_SHARE,
    ),
    basis=basis,
    bases=bases,
    forward="play",
)
