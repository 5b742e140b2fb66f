"""Work that an error of the gravity torque does: the columns that keep it out of the friction coefficients.

An error in the mass or the centre of mass beyond joint i gives a torque c_x g_x + c_y g_y on its axis, with (g_x, g_y)
the direction of gravity in the plane across the axis, seen from the moving link, and (c_x, c_y) unknown constants. For
one joint with a horizontal axis this is the sin q and cos q of a pendulum.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float


def gravity_work(interaction: Interaction, column: int, edges: NDArray[np.int64]) -> tuple[Float, Float]:
    """Integrate g_x dq and g_y dq over the parts of each cycle.

    Args:
        interaction: The interaction.
        column: Joint, 0-based.
        edges: Border samples of the parts, shape (m, p + 1).

    Returns:
        Two arrays of shape (m, p). [rad]
    """
    q = interaction.q[:, column]
    if interaction.gravity_direction is None or interaction.gravity_index is None:
        return np.diff(-np.cos(q[edges]), axis=1), np.diff(np.sin(q[edges]), axis=1)
    index = interaction.gravity_index
    step = np.diff(q[index])
    direction = interaction.gravity_direction[:, column, :]
    work = np.zeros_like(direction)
    work[1:] = np.cumsum(0.5 * (direction[1:] + direction[:-1]) * step[:, None], axis=0)
    x, y = (np.diff(np.interp(edges, index, work[:, k]), axis=1) for k in range(2))
    return x, y
