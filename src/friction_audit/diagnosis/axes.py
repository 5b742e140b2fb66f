"""What a residual is held against: quantities along which a missing effect may show itself."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.effects.joint_data import JointData, strokes
from friction_audit.joint_log import Float

KNOTS = 6


@dataclass(frozen=True, kw_only=True, slots=True)
class Axis:
    """A quantity of every sample.

    Attributes:
        name: One word.
        label: For the axis of a figure, with the unit.
        value: ``value(data)``: the quantity, shape (n,), or None where the log does not have it.
    """

    name: str
    label: str
    value: Callable[[JointData], Float | None]


def _travelled(data: JointData) -> Float:
    return np.abs(strokes(data).displacement)


def _neighbour(data: JointData) -> Float | None:
    """Acceleration of the other joint that moves most, in its own units."""
    others: Float = np.delete(data.others_ddq, data.own_column, axis=1)
    return others[:, int(np.argmax(others.std(axis=0)))] if others.shape[1] else None


AXES: tuple[Axis, ...] = (
    Axis(name="speed", label="speed [rad/s]", value=lambda data: np.abs(data.dq)),
    Axis(name="position", label="position [rad]", value=lambda data: data.q),
    Axis(name="displacement", label="displacement since reversal [rad]", value=_travelled),
    Axis(name="acceleration", label="acceleration [rad/s²]", value=lambda data: data.ddq),
    Axis(name="time", label="time [s]", value=lambda data: data.t),
    Axis(name="load", label="predicted load [N m]", value=lambda data: data.load),
    Axis(name="temperature", label="temperature [°C]", value=lambda data: data.temperature),
    Axis(name="neighbour", label="acceleration of a neighbour [rad/s²]", value=_neighbour),
)
"""All axes, in the order in which they are told when equal."""


def knots_of(values: Float, counted: NDArray[np.bool_], most: int = KNOTS) -> Float:
    """Quantiles of a quantity over the samples that count, without repetition, shape (k,); k below 2 if constant."""
    if not counted.any():
        return np.zeros(0)
    knots = np.unique(np.quantile(values[counted], np.linspace(0.0, 1.0, most)))
    apart = np.diff(knots) > 1e-9 * max(float(np.ptp(knots)), 1e-12)
    return np.asarray(knots[np.append(True, apart)], np.float64)


def curve(values: Float, knots: Float, dq: Float) -> Float:
    """A piecewise linear curve over a quantity for each direction of motion, shape (n, 2 k)."""
    # One column behind the other, as whatever filters them wants them.
    hats = np.stack([np.interp(values, knots, row) for row in np.eye(len(knots))])
    up = dq > 0
    return np.concatenate([hats * up, hats * ~up]).T
