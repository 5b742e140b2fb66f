"""Gravity that is not what was taken away: of the joint's own angle, of links of the arm, or of a tilted base.

One joint alone cannot tell a wrong mass from a wrong centre of mass or a tilted base: all are an amplitude and a phase
of its angle. An arm can: a link that is heavier than its model pulls at each joint as the pose says (the columns of
gravity in the arm's regressor; Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

OWN_ANGLE, TILT, SEVERAL = 0, -1, -2
"""Values of the source; from 1 on, the number of a link."""
OF_ANGLE, OF_LINK, OF_TILT = slice(0, 2), slice(2, 6), slice(6, 8)
"""Columns of the sources."""
OF_LINKS = (OF_LINK, slice(8, 12), slice(12, 16))
"""Columns of the joint's own link, the next and the last where several are wrong."""
OF_ONE = 8
"""Columns in front that belong to an error of one source; the others are of several links only."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return the columns of one source of the error; those of the others are zero."""
    source = round(shape[0])
    columns = np.zeros((len(TERM.coefficients), len(motion.t))).T  # one behind the other in memory
    if source == OWN_ANGLE:
        columns[:, OF_ANGLE] = np.column_stack([np.cos(motion.q), np.sin(motion.q)])
    elif motion.rigid is None:
        return columns
    elif source == TILT:
        columns[:, OF_TILT] = motion.rigid.at(motion.t, motion.rigid.tilt)
    elif source == SEVERAL:
        weight = motion.rigid.at(motion.t, motion.rigid.weight)
        for k, where in enumerate(OF_LINKS[: weight.shape[1]]):
            columns[:, where] = weight[:, k]
    elif source in motion.rigid.links:
        columns[:, OF_LINK] = motion.rigid.at(motion.t, motion.rigid.weight[:, motion.rigid.links.index(source)])
    return columns


def _of_another(link: str) -> Iterator[Parameter]:
    """Yield the numbers of a link besides the first, which files of earlier versions do not have."""
    for axis in "xyz":
        yield Parameter(
            name=f"{link}_link_moment_{axis}_kg_m",
            unit="kg m",
            meaning=f"mass times centre of mass of the {link} link, {axis} in its joint's frame",
            optional=True,
        )
    yield Parameter(
        name=f"{link}_link_mass_kg", unit="kg", meaning=f"mass of the {link} link more than in the model", optional=True
    )


TERM = Term(
    name="gravity_error",
    label="gravity is not what was taken away",
    coefficients=(
        Parameter(name="gravity_cos_nm", unit="N m", meaning="of the cosine of the joint's angle"),
        Parameter(name="gravity_sin_nm", unit="N m", meaning="of the sine of the joint's angle"),
        Parameter(name="link_moment_x_kg_m", unit="kg m", meaning="mass times centre of mass, x in the joint's frame"),
        Parameter(name="link_moment_y_kg_m", unit="kg m", meaning="the same, y"),
        Parameter(name="link_moment_z_kg_m", unit="kg m", meaning="the same, z"),
        Parameter(name="link_mass_kg", unit="kg", meaning="mass of the link more than in the model"),
        Parameter(name="gravity_across_1_m_s2", unit="m/s^2", meaning="gravity across the vertical: a tilted base"),
        Parameter(name="gravity_across_2_m_s2", unit="m/s^2", meaning="the same, at right angles"),
        *_of_another("next"),
        *_of_another("last"),
    ),
    nonlinear=(
        Parameter(
            name="gravity_error_source",
            unit="1",
            meaning="0 own angle, -1 base, -2 several links, else number of the link",
            lower=SEVERAL,
            whole=True,
        ),
    ),
    basis=basis,
)
