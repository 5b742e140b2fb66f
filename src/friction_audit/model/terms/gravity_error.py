"""Gravity that is not what was taken away: of the joint's own angle, of a link of the arm, or of a tilted base.

One joint alone cannot tell a wrong mass from a wrong centre of mass or a tilted base: all are an amplitude and a phase
of its angle. An arm can: a link that is heavier than its model pulls at each joint as the pose says (the columns of
gravity in the arm's regressor; Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986).
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term

OWN_ANGLE, TILT = 0, -1
"""Values of the source; from 1 on, the number of a link."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return the columns of one source of the error; those of the others are zero."""
    source = round(shape[0])
    columns = np.zeros((len(motion.t), len(TERM.linear)))
    if source == OWN_ANGLE:
        columns[:, :2] = np.column_stack([np.cos(motion.q), np.sin(motion.q)])
    elif motion.rigid is None:
        return columns
    elif source == TILT:
        columns[:, 6:] = motion.rigid.at(motion.t, motion.rigid.tilt)
    elif source in motion.rigid.links:
        columns[:, 2:6] = motion.rigid.at(motion.t, motion.rigid.weight[:, motion.rigid.links.index(source)])
    return columns


TERM = Term(
    name="gravity_error",
    label="gravity is not what was taken away",
    linear=(
        Parameter(name="gravity_cos_nm", unit="N m", meaning="of the cosine of the joint's angle"),
        Parameter(name="gravity_sin_nm", unit="N m", meaning="of the sine of the joint's angle"),
        Parameter(name="link_moment_x_kg_m", unit="kg m", meaning="mass times centre of mass, x in the joint's frame"),
        Parameter(name="link_moment_y_kg_m", unit="kg m", meaning="the same, y"),
        Parameter(name="link_moment_z_kg_m", unit="kg m", meaning="the same, z"),
        Parameter(name="link_mass_kg", unit="kg", meaning="mass of the link more than in the model"),
        Parameter(name="gravity_across_1_m_s2", unit="m/s^2", meaning="gravity across the vertical: a tilted base"),
        Parameter(name="gravity_across_2_m_s2", unit="m/s^2", meaning="the same, at right angles"),
    ),
    shape=(
        Parameter(
            name="gravity_error_source",
            unit="1",
            meaning="0 own angle, -1 base, else number of the link",
            lower=TILT,
            whole=True,
        ),
    ),
    basis=basis,
)
