"""JointLog -> NumPy archive with the keys of panda-py's ``get_log()``."""

from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import JointLog


def write_npz(log: JointLog, path: Path) -> None:
    """Write one array of shape (n, j) per channel; ``time`` is in milliseconds and has shape (n, 1)."""
    arrays: dict[str, Any] = {"time": np.round(log.t * 1000.0, 6)[:, np.newaxis], **log.channels()}
    with path.open("wb") as stream:
        np.savez_compressed(stream, joint_names=np.array(log.joint_names), **arrays)


NPZ = Writer(
    name="npz",
    suffix=".npz",
    write=write_npz,
    summary="NumPy archive with the keys of panda-py's get_log(); milliseconds, other numbers to the bit",
    lossless=False,
)
