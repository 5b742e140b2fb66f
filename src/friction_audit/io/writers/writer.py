"""What a writer is: one record per file format and dialect."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from friction_audit.joint_log import JOINT_CHANNELS, JointLog


@dataclass(frozen=True, kw_only=True, slots=True)
class Writer:
    """A file format or dialect.

    Attributes:
        name: Unique name, e.g. ``"parquet"``, ``"rosbag1-franka-state"``.
        suffix: File name ending with the dot, or ``""`` for a directory; several writers may share one, the first in
            WRITERS is its default.
        write: Writes the log to a path that does not exist yet; the caller renames it into place.
        summary: One line for help and documentation.
        lossless: True if reading the file back gives the same numbers to the bit, stamps of whole nanoseconds given.
        holds: Channels that the dialect has a place for.
        joints: Number of joints that it holds, or None for any.
    """

    name: str
    suffix: str
    write: Callable[[JointLog, Path], None]
    summary: str
    lossless: bool = True
    holds: tuple[str, ...] = JOINT_CHANNELS
    joints: int | None = None

    @property
    def needs(self) -> tuple[str, ...]:
        """Channels without which it makes no sense: a dialect that does not hold all has a place for the effort."""
        return () if self.holds == JOINT_CHANNELS else ("tau_J",)

    def left_out(self, log: JointLog) -> tuple[str, ...]:
        """Return the channels of a log that this dialect has no place for."""
        return tuple(name for name in log.channels() if name not in self.holds)
