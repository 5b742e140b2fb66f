"""What a writer is: one record per file format and dialect."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from friction_audit.joint_log import JointLog


@dataclass(frozen=True, kw_only=True, slots=True)
class Writer:
    """A file format or dialect.

    Attributes:
        name: Unique name, e.g. ``"parquet"``, ``"rosbag1-franka-state"``.
        suffix: File name ending with the dot; several writers may share one, the first in WRITERS is its default.
        write: Writes the log to a path that does not exist yet; the caller renames it into place.
        summary: One line for help and documentation.
        lossless: True if reading the file back gives the same log to the bit.
    """

    name: str
    suffix: str
    write: Callable[[JointLog, Path], None]
    summary: str
    lossless: bool = True
