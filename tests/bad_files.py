"""Small logs in the form of every reader, and the ways in which such files go wrong."""

import copy
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from friction_audit.io.writers.write_log import WRITERS
from friction_audit.joint_log import Float, JointLog, Source

SAMPLES = 400
RATE_HZ = 200.0
JOINTS = ("shoulder", "elbow")

TABLES = {"csv": "log.csv", "csv-long": "log.csv", "parquet": "log.parquet", "npz": "log.npz"}
BAGS = {
    "rosbag1-joint-state": "log.bag",
    "rosbag2-db3": "log.db3",
    "rosbag2-sqlite3": "log_bag",
    "rosbag2-mcap": "log_bag",
    "mcap": "log.mcap",
    "mcap-ros1": "log.mcap",
    "mcap-json": "log.mcap",
    "mcap-protobuf": "log.mcap",
}
FORMS: Mapping[str, str] = {**TABLES, **BAGS}
"""Dialect of a writer -> name of the file or directory, at least one for every reader and every encoding."""


def swinging_log(samples: int = SAMPLES) -> JointLog:
    """Return a log of two joints that swing."""
    t = np.arange(max(samples, 2)) / RATE_HZ
    rate = np.array([3.0, 4.0])
    q, dq = 0.5 * np.sin(np.outer(t, rate)), 0.5 * rate * np.cos(np.outer(t, rate))
    source = Source(path="made", sha256="0" * 64, format="made", start_s=1.7e9)
    log = JointLog(t=t, q=q, dq=dq, tau_J=0.3 * np.sign(dq) + 0.1 * dq, joint_names=JOINTS, source=source)
    return with_arrays(log, **{name: array[:samples] for name, array in {"t": log.t, **log.channels()}.items()})


def with_arrays(log: JointLog, **arrays: Float) -> JointLog:
    """Return a log with other arrays, whatever a JointLog promises: files promise nothing."""
    spoiled = copy.copy(log)
    for name, array in arrays.items():
        object.__setattr__(spoiled, name, array)
    return spoiled


def write(folder: Path, dialect: str, log: JointLog | None = None, name: str | None = None) -> Path:
    """Write a log in a dialect and return its path."""
    path = folder / (name or FORMS[dialect])
    writer = next(writer for writer in WRITERS if writer.name == dialect)
    writer.write(swinging_log() if log is None else log, path)
    return path


def storage_of(path: Path) -> Path:
    """Return the file itself, or the storage file in the directory of a bag."""
    return next(file for file in path.iterdir() if file.suffix in (".db3", ".mcap")) if path.is_dir() else path


def cut(path: Path, share: float = 0.6) -> Path:
    """Leave the beginning of a file, as a broken copy does."""
    storage = storage_of(path)
    content = storage.read_bytes()
    storage.write_bytes(content[: int(len(content) * share)])
    return path


def replace_content(path: Path, content: bytes) -> Path:
    """Put something else under the name of a log."""
    storage_of(path).write_bytes(content)
    return path


def _not_finite(log: JointLog, value: float) -> JointLog:
    spoiled = np.array(log.tau_J)
    spoiled[100:110, 1] = value
    return with_arrays(log, tau_J=spoiled)


SPOILED: Mapping[str, Callable[[], JointLog]] = {
    "nan": lambda: _not_finite(swinging_log(), np.nan),
    "infinity": lambda: _not_finite(swinging_log(), np.inf),
    "only nan": lambda: with_arrays(swinging_log(), tau_J=np.full((SAMPLES, 2), np.nan)),
    "zero samples": lambda: swinging_log(0),
    "one sample": lambda: swinging_log(1),
    "constant time": lambda: with_arrays(swinging_log(), t=np.zeros(SAMPLES)),
    "time runs back": lambda: with_arrays(swinging_log(), t=swinging_log().t[::-1].copy()),
}
"""Fault -> a log that has it."""


def copy_of(path: Path, folder: Path) -> Path:
    """Copy a file or a directory, to spoil the copy."""
    target = folder / path.name
    shutil.copytree(path, target) if path.is_dir() else shutil.copy(path, target)
    return target
