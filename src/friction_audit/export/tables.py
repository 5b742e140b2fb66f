"""The columns of a log as tables have them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float, JointLog

NANOSECONDS = 1_000_000_000

UNKNOWN_START_NS = NANOSECONDS
"""First stamp of a log whose clock does not tell the time; a stamp of 0 would mean 'not set' in ROS."""

Column = Float | NDArray[np.int64] | NDArray[np.object_]
"""Numbers, stamps or words."""


def stamps_ns(log: JointLog) -> NDArray[np.int64]:
    """Return the Unix time of every sample, shape (n,). [ns]"""
    start = UNKNOWN_START_NS if log.source.start_s is None else round(log.source.start_s * NANOSECONDS)
    return start + np.rint(log.t * NANOSECONDS).astype(np.int64)


def joint_columns(
    log: JointLog, name: Callable[[str, int], str], channels: tuple[str, ...] | None = None
) -> dict[str, Column]:
    """Return one column per channel and joint, joints of one channel side by side.

    Args:
        log: The log.
        name: Name of the column of a channel and a joint (0-based).
        channels: Which channels, or None for all that were recorded.
    """
    recorded = log.channels()
    kept = [channel for channel in recorded if channels is None or channel in channels]
    return {name(channel, j): recorded[channel][:, j] for channel in kept for j in range(len(log.joint_names))}


def tidy_columns(log: JointLog) -> dict[str, Column]:
    """Return ``time`` [s], then ``q_1``, ``q_2``, ... of every channel that was recorded."""
    return {"time": log.t, **joint_columns(log, lambda channel, joint: f"{channel}_{joint + 1}")}
