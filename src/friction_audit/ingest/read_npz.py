"""NumPy .npz -> Recording: panda-py's ``get_log()`` as people save it, or arrays under house names."""

import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.ingest.columns import map_columns
from friction_audit.ingest.first_bytes import starts_with
from friction_audit.ingest.reader import Reader, ReadOptions, Recording, Topic
from friction_audit.ingest.time_column import to_clock
from friction_audit.ingest.to_recording import name_joints, stated_arm, to_recording

_PANDA_PY = {"O_T_EE", "control_command_success_rate", "time"}
_TABLE_DIMENSIONS = 2
_ZIP_MAGIC = b"PK"
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    tokenize.TokenError,
    SyntaxError,
    OSError,
    EOFError,
    ValueError,
    NotImplementedError,
)
"""What NumPy and the zip module raise on a damaged archive."""


def read_npz(path: Path, options: ReadOptions) -> Recording:
    """Read a NumPy archive; pickled objects are never unpacked.

    Raises:
        InputError: If arrays are missing, pickled or of unequal length, or the file is damaged.
    """
    arm = stated_arm(path, options)
    loaded = _load(path)
    arrays = {name: _as_table(array) for name, array in loaded.items() if array.dtype.kind in "fiu"}
    cells = [(n, e) for n, array in arrays.items() for e in (range(array.shape[1]) if array.ndim > 1 else (None,))]
    names = [name if element is None else f"{name}[{element}]" for name, element in cells]
    joints = [str(name) for name in loaded.get("joint_names", ())]
    wide = {name for name, array in arrays.items() if array.ndim > 1 and array.shape[1] == len(joints)}
    labels = {cell: joints[e] for cell, (name, e) in enumerate(cells) if e is not None and name in wide}
    columns = map_columns(names, path=str(path), mapping=options.mapping, labels=labels, arm=arm)
    time = np.squeeze(arrays[cells[columns.time.cells[0]][0]])
    raw: NDArray[Any] = time.astype(np.int64 if time.dtype.kind in "iu" else np.float64).reshape(-1)
    channels = {}
    for channel, own in columns.channels.items():
        channels[channel] = np.empty((len(raw), len(own)), order="F")
        for joint, cell in enumerate(own):
            name, element = cells[cell]
            _check_length(path, name, arrays[name], len(raw))
            channels[channel][:, joint] = arrays[name] if element is None else arrays[name][:, element]
    panda_py = arrays.keys() >= _PANDA_PY and columns.time.name == "time"
    clock = to_clock(raw, "ms" if panda_py else columns.time.unit, path=str(path))
    recording = to_recording(columns, clock, channels)
    recording.clock = "robot_time" if panda_py else recording.clock
    return recording if labels else name_joints(recording, joints)


def _load(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays in the archive."""
    if not starts_with(path, _ZIP_MAGIC):
        raise InputError(
            f"{path}: does not begin as a zip archive; expected one written by numpy.savez; save it again that way"
        )
    try:
        # The stream is opened here: NumPy leaves it open when the archive is damaged.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            loaded = {name: _array(archive, name, path) for name in archive.files}
    except _DAMAGED as error:
        raise InputError(f"{path}: a damaged NumPy archive: {error}; copy or save it again") from error
    return {name: array for name, array in loaded.items() if array.ndim > 0}


def _array(archive: Mapping[str, NDArray[Any]], name: str, path: Path) -> NDArray[Any]:
    try:
        return archive[name]
    except ValueError as error:
        if "allow_pickle" not in str(error):
            raise
        raise InputError(
            f"{path}: array {name!r} is pickled, which could run foreign code when it is read; save plain arrays: "
            "numpy.savez(file, **{name: numpy.asarray(values, dtype=float) for name, values in log.items()})"
        ) from error


def _as_table(array: NDArray[Any]) -> NDArray[Any]:
    """Return (n,) or (n, k); panda-py keeps scalars as vectors of length 1."""
    if array.ndim > _TABLE_DIMENSIONS:
        array = array.reshape(len(array), -1)
    return array[:, 0] if array.ndim == _TABLE_DIMENSIONS and array.shape[1] == 1 else array


def _check_length(path: Path, name: str, array: NDArray[Any], rows: int) -> None:
    if len(array) != rows:
        raise InputError(
            f"{path}: {name} has shape {array.shape}, time has {rows} samples; expected one row per sample; "
            "save it transposed or cut to the same length"
        )


def _recognises(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.endswith(".npy") for name in archive.namelist())
    except _DAMAGED:
        return path.is_file() and path.suffix.lower() == ".npz" and starts_with(path, _ZIP_MAGIC)


def _tables(path: Path) -> tuple[Topic, ...]:
    return tuple(
        Topic(name=name, type=f"array {array.shape} {array.dtype}", messages=len(array), readable=True)
        for name, array in _load(path).items()
    )


NPZ = Reader(
    name="npz",
    suffixes=(".npz",),
    recognises=_recognises,
    read=read_npz,
    topics=_tables,
    summary="NumPy archives: panda-py's get_log(), or arrays (n, joints) under house names",
)
