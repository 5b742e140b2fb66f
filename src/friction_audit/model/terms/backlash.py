"""Backlash: play between the side that is measured and the side that rubs.

Where the torque changes sign the far side flies free, friction alone on it, until the measured side has crossed the
play and strikes it on the other flank.
"""

from collections.abc import Iterator, Sequence
from math import pi, sqrt

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term
from friction_audit.model.transmission import HIGHEST_HZ, Transmission, added_torques, far_side, part_of, simple_torque

CONTACT_DAMPING_RATIO = 0.2
"""Of metal on lubricated metal: half of the speed is left after an impact."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what play in front of all inertia and friction adds to the torque, as a column."""
    ((_, column),) = bases(motion, [shape])
    return column


def bases(motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield the same for many shapes, behind which is one inertia."""
    yield from added_by_plays(motion, [(gap, contact_hz, CONTACT_DAMPING_RATIO) for gap, contact_hz in shapes])


def added_by_plays(
    motion: Motion, plays: Sequence[tuple[float, float, float]], share: float = 1.0
) -> Iterator[tuple[int, Float]]:
    """Yield the same for many plays, each with the ringing [Hz] and the damping ratio of a flank that touches.

    Behind them is this share of the inertia, and all friction.
    """
    far, torque = part_of(far_side(motion), share), simple_torque(motion)
    usual = sqrt(torque @ torque / len(torque))
    flanks = [
        Transmission(
            # Flanks that gave way by more than the play would be a spring, and that has its own name.
            stiffness_nm_per_rad=max(far.inertia_kg_m2 * (2.0 * pi * min(contact_hz, HIGHEST_HZ)) ** 2, usual / gap),
            damping_ratio=damping_ratio,
            gap_rad=gap,
        )
        for gap, contact_hz, damping_ratio in plays
    ]
    for place, added in added_torques(motion, far, flanks):
        yield place, added[:, None]


TERM = Term(
    name="backlash",
    label="free play between motor and link",
    linear=(
        Parameter(
            name="backlash_share",
            unit="1",
            meaning="share of inertia and friction behind the play",
            lower=0.0,
            upper=1.5,
        ),
    ),
    shape=(
        Parameter(name="gap_rad", unit="rad", meaning="full width of the play", lower=1e-7, upper=1.0),
        Parameter(name="contact_hz", unit="Hz", meaning="ringing on a flank that touches", lower=1.0, upper=1e3),
    ),
    basis=basis,
    bases=bases,
    forward="play",
)
