"""What an effect is drawn along where no single quantity shows it: one of its waves, or its own torque."""

from typing import NamedTuple

import numpy as np

from friction_audit.discrepancy.result import Effect, Traces
from friction_audit.joint_log import Float

ORDER = "ripple_order"
"""Parameter of an effect that repeats with the position: its waves per revolution."""
OF_SEVERAL_JOINTS = ("inertial_coupling", "torque_crosstalk")
"""Effects that follow several joints at once."""
SOURCE = "gravity_error_source"
"""Parameter of an effect that does too, unless it is 0: the joint's own angle."""
POINTS = 60
"""Stretches of the axis, with equally many rows each, over which a torque is averaged for a line."""


class OwnAxis(NamedTuple):
    """A quantity of every row, shape (m,), and what the axis is called."""

    label: str
    values: Float


def own_axis(effect: Effect, traces: Traces) -> OwnAxis | None:
    """Return what the effect is drawn along; None where the axis of its curve shows it.

    A ripple is drawn over one wave, for bins in place would average it away. What follows the motion of other joints is
    drawn over the torque that was fitted: on the diagonal, all that it says is in the log.
    """
    if ORDER in effect.parameters:
        waves = effect.parameters[ORDER].value * traces.q / (2 * np.pi)
        return OwnAxis("Position within a wave [waves]", np.mod(waves, 1.0))
    source = effect.parameters.get(SOURCE)
    if effect.name in OF_SEVERAL_JOINTS or (source is not None and source.value != 0.0):
        return OwnAxis(f"{effect.name}, fitted [N m]", effect.torque)
    return None


def mean_along(along: Float, torque: Float, points: int = POINTS) -> tuple[Float, Float]:
    """Return the mean of both over stretches of the axis with equally many rows.

    Args:
        along: The quantity of the axis, shape (m,).
        torque: Shape (m,). [N m]
        points: Stretches at most.
    """
    order = np.argsort(along, kind="stable")
    parts = [part for part in np.array_split(order, points) if len(part)]
    return np.array([along[part].mean() for part in parts]), np.array([torque[part].mean() for part in parts])
