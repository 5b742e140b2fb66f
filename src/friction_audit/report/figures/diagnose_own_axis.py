"""What an effect is drawn along where no single quantity shows it: one of its waves, or its own torque."""

from typing import NamedTuple

import numpy as np

from friction_audit.discrepancy.profiles import bin_means
from friction_audit.discrepancy.result import Effect, Profile, Traces
from friction_audit.discrepancy.shown_along import shows_along
from friction_audit.joint_log import Float

ORDER = "ripple_order"
"""Parameter of an effect that repeats with the position: its waves per revolution."""
OF_SEVERAL_JOINTS = ("inertial_coupling", "torque_crosstalk")
"""Effects that follow several joints at once."""
SOURCE = "gravity_error_source"
"""Parameter of an effect that does too, unless it is 0: the joint's own angle."""
POINTS = 60
"""Stretches of the axis, with equally many rows each, over which a torque is averaged for a line."""
BINS = 12


class OwnAxis(NamedTuple):
    """A quantity of every row, shape (m,), and what the axis is called."""

    label: str
    values: Float


def own_axis(effect: Effect, traces: Traces) -> OwnAxis | None:
    """Return what the effect is drawn along; None where the axis of its curve shows it.

    A ripple is drawn over one wave, for bins in place would average it away. What follows several joints, or is no
    curve over its axis, as the ringing of a spring, is drawn over the torque that was fitted: on the diagonal, all that
    it says is in the log.
    """
    if ORDER in effect.parameters:
        waves = effect.parameters[ORDER].value * traces.q / (2 * np.pi)
        return OwnAxis("Position within a wave [waves]", np.mod(waves, 1.0))
    source = effect.parameters.get(SOURCE)
    alone = effect.name not in OF_SEVERAL_JOINTS and (source is None or source.value == 0.0)
    if alone and shows_along(effect.torque, traces.along[effect.curve.axis], traces.dq):
        return None
    return OwnAxis(f"Fitted torque of {effect.name} [N m]", effect.torque)


def own_profile(own: OwnAxis, traces: Traces, torque: Float) -> Profile:
    """Return the means of a torque over an axis of an effect's own, in bins of equal width.

    Args:
        own: The axis.
        traces: The rows of the joint.
        torque: Of every row, shape (m,). [N m]
    """
    edges = np.linspace(own.values.min(), own.values.max(), BINS + 1)
    bins = np.clip(np.searchsorted(edges, own.values, side="right") - 1, 0, BINS - 1)
    forwards, forwards_se = bin_means(torque, bins, traces.cycle, traces.dq > 0, BINS)
    backwards, backwards_se = bin_means(torque, bins, traces.cycle, traces.dq <= 0, BINS)
    return Profile(
        axis=own.label,
        label=own.label,
        edges=edges,
        centre=0.5 * (edges[:-1] + edges[1:]),
        forwards=forwards,
        backwards=backwards,
        forwards_se=forwards_se,
        backwards_se=backwards_se,
        share=float("nan"),
        p_value=float("nan"),
        where="",
    )


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
