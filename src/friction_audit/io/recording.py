"""A recording as a reader returns it, before its faults are looked for."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Finding, Float


class WholeLogError(Exception):
    """A recording cannot be read block by block: what is wrong with it needs all samples at once."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Blocks:
    """A recording that is read block by block, anew for every pass.

    Attributes:
        rows: Number of samples.
        read: Yields the clock of each block, and those of its channels that are asked for.
        clock, gaps, mean_of, numbers: What the checks found, as in ``LogInBlocks``.
    """

    rows: int
    read: Callable[[Collection[str]], Iterator[tuple[Float, dict[str, Float]]]]
    clock: tuple[int, float, float] = (0, 0.0, 0.0)
    gaps: Float = field(default_factory=lambda: np.zeros((0, 3)))
    mean_of: int = 1
    numbers: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))


@dataclass(eq=False, kw_only=True, slots=True)
class Recording:
    """What a reader returns: names and units translated, faults not yet looked for.

    The arrays belong to the receiver, which may work in place.

    Attributes:
        t: Time since an origin of the reader's choice, shape (n,); any order, repeats allowed. [s]
        channels: Channel of JointLog -> array of shape (n, j), Fortran order, NaN where nothing was recorded.
        joint_names: One name per joint.
        clock: ``"robot_time"``, ``"header_stamp"``, ``"log_time"`` or ``"column"``.
        start_s: Unix time of t = 0, or None when the clock does not say. [s]
        origin_s: Reading of the clock at t = 0. [s]
        guessed_unit: Unit of the clock where neither its name nor its size says it.
        first_s: Time of the log's first sample on the clock of t where only a part was read, else None. [s]
        robot: Robot by joint names or message types, or ``"unknown"``.
        serial: Serial number of the arm as the file states it, empty if it does not.
        topic: Topic read, or None.
        mapping: Channel -> name in the file, with ``{i}``.
        torque_unit: Unit of the torque where it was converted; empty where its name decides.
        clock_windows: Windows of time on which the clock was checked against the motion.
        findings: What the reader itself noticed (a truncated file, a topic without content).
        blocks: How it is read block by block; ``t`` and the channels are then empty, or means of the blocks.
    """

    t: Float
    channels: dict[str, Float]
    joint_names: tuple[str, ...]
    clock: str = "column"
    start_s: float | None = None
    origin_s: float = 0.0
    guessed_unit: str = ""
    first_s: float | None = None
    robot: str = "unknown"
    serial: str = ""
    topic: str | None = None
    mapping: Mapping[str, str] = field(default_factory=dict)
    torque_unit: str = ""
    clock_windows: int = 0
    findings: tuple[Finding, ...] = ()
    blocks: Blocks | None = None

    def with_findings(self, *findings: Finding | None) -> "Recording":
        """Return the recording with findings added."""
        new = tuple(finding for finding in findings if finding is not None)
        return replace(self, findings=(*self.findings, *new)) if new else self

    def take_rows(self, rows: NDArray[Any]) -> "Recording":
        """Return the rows of a mask or in an order; works in place, one column at a time, without a second copy."""
        count = int(np.count_nonzero(rows)) if rows.dtype == np.bool_ else len(rows)
        for array in self.channels.values():
            for column in array.T:
                column[:count] = column[rows]
        return replace(self, t=self.t[rows], channels={name: array[:count] for name, array in self.channels.items()})

    def take_joints(self, joints: Sequence[int]) -> "Recording":
        """Return some joints only, given by column."""
        kept = {channel: np.asfortranarray(array[:, list(joints)]) for channel, array in self.channels.items()}
        return replace(self, channels=kept, joint_names=tuple(self.joint_names[joint] for joint in joints))

    def name_of(self, channel: str, joint: int) -> str:
        """Return how messages call a channel of a joint (0-based)."""
        return f"{channel} ({self.mapping.get(channel, channel)}) of {self.joint_names[joint]}"
