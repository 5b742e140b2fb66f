"""Backlash: play between the side that is measured and the side that rubs.

Where the torque changes sign the far side flies free, friction alone on it, until the measured side has crossed the
play and strikes it on the other flank.
"""

from collections.abc import Sequence

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term
from friction_audit.model.transmission import added_torque

CONTACT_NM_PER_RAD = 2e4
"""Stiffness of the flanks: so high that of an impact only its momentum passes the filter of a regression."""
CONTACT_DAMPING_RATIO = 0.2
"""Of metal on lubricated metal."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what play in front of all inertia and friction adds to the torque, as a column."""
    (gap,) = shape
    return added_torque(motion, CONTACT_NM_PER_RAD, CONTACT_DAMPING_RATIO, gap)[:, None]


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
    shape=(Parameter(name="gap_rad", unit="rad", meaning="full width of the play", lower=0.0, upper=1.0),),
    basis=basis,
    forward="play",
)
