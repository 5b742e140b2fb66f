"""NumPy .npz -> Recording: panda-py's ``get_log()`` as people save it, or arrays under house names."""

import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.columns import MOST_JOINTS, ColumnMap, map_columns
from friction_audit.io.readers.reader import Reader, ReadOptions, Recording, Topic, refuse_too_large
from friction_audit.io.readers.time_column import Clock, take_part, to_clock
from friction_audit.io.readers.to_recording import name_joints, stated_arm, to_recording
from friction_audit.io.readers.unpack import starts_with
from friction_audit.joint_log import Finding, Float

_PANDA_PY = {"O_T_EE", "control_command_success_rate", "time"}
_ZIP_MAGIC = b"PK"
_CHUNK_BYTES = 8 << 20
_NAMES_BYTES = 1 << 20
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    tokenize.TokenError,
    SyntaxError,
    OSError,
    EOFError,
    LookupError,
    OverflowError,
    ValueError,
    RuntimeError,
)
"""What NumPy and the zip module raise on a damaged archive."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Entry:
    """An array in the archive, by what its header says.

    Attributes:
        info: Its place in the archive.
        shape: Its shape.
        dtype: What it holds.
        by_column: True if it is stored column by column.
        offset: Length of the header. [bytes]
    """

    info: zipfile.ZipInfo
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    by_column: bool
    offset: int

    @property
    def width(self) -> int:
        """Numbers per row."""
        return prod(self.shape[1:])


def read_npz(path: Path, options: ReadOptions) -> Recording:
    """Read a NumPy archive; pickled objects are never unpacked.

    Raises:
        InputError: If arrays are missing, pickled or of unequal length, or the file is damaged.
    """
    arm = stated_arm(path, options)
    with _opened(path) as archive:
        entries, damage = _entries(archive, path)
        tables = {name: e for name, e in entries.items() if e.dtype.kind in "fiu" and e.width <= MOST_JOINTS}
        # panda-py keeps scalars as vectors of length 1
        cells = [(n, e) for n, entry in tables.items() for e in (range(entry.width) if entry.width != 1 else (None,))]
        names = [name if element is None else f"{name}[{element}]" for name, element in cells]
        joints = _joint_names(archive, entries)
        wide = {name for name, entry in tables.items() if entry.width == len(joints) > 1}
        labels = {cell: joints[e] for cell, (name, e) in enumerate(cells) if e is not None and name in wide}
        try:
            columns = map_columns(names, path=str(path), mapping=options.mapping, labels=labels, arm=arm)
        except InputError as error:
            raise InputError("; ".join((str(error), *(finding.message for finding in damage)))) from error
        panda_py = tables.keys() >= _PANDA_PY and columns.time.name == "time"
        clock, channels, first_s = _Numbers(archive, path, tables, cells).read(columns, options, is_panda=panda_py)
    recording = to_recording(columns, clock, channels, findings=damage)
    recording = replace(recording, first_s=first_s, clock="robot_time" if panda_py else recording.clock)
    return recording if labels else name_joints(recording, joints)


class _Numbers:
    """The numbers of an archive."""

    def __init__(
        self,
        archive: zipfile.ZipFile,
        path: Path,
        entries: Mapping[str, Entry],
        cells: Sequence[tuple[str, int | None]],
    ) -> None:
        self._archive, self._path, self._entries, self._cells = archive, path, entries, cells

    def read(
        self, columns: ColumnMap, options: ReadOptions, *, is_panda: bool
    ) -> tuple[Clock, dict[str, Float], float | None]:
        """Return clock, channels, and the log's first stamp if only a part of it was read."""
        time = self._cells[columns.time.cells[0]]
        wanted = {self._cells[cell][0] for own in columns.channels.values() for cell in own}
        samples = self._entries[time[0]].shape[0]
        for name in sorted(wanted):
            self._check_length(name, samples)
        packed = sum(self._entries[name].info.compress_size for name in {time[0], *wanted})
        needed = 8 * samples * (1 + sum(map(len, columns.channels.values())))
        is_part = options.reads_part(needed)
        refuse_too_large(self._path, 8 * samples if is_part else needed, packed)
        stamps = _column(_array(self._archive, self._entries[time[0]]), time[1])
        raw: NDArray[Any] = stamps.astype(np.int64 if stamps.dtype.kind in "iu" else np.float64)
        clock = to_clock(raw, "ms" if is_panda else columns.time.unit, path=str(self._path))
        rows: NDArray[np.bool_] = np.ones(samples, dtype=np.bool_)
        first_s = None
        if is_part:
            clock, rows, first_s = take_part(clock, options, path=str(self._path))
            refuse_too_large(self._path, needed // samples * len(clock.t), packed)
        return clock, {c: self._channel(own, rows, is_part=is_part) for c, own in columns.channels.items()}, first_s

    def _channel(self, cells: Sequence[int], rows: NDArray[np.bool_], *, is_part: bool) -> Float:
        first, last = int(rows.argmax()), len(rows) - int(rows[::-1].argmax())
        channel = np.empty((int(np.count_nonzero(rows)), len(cells)), order="F")
        arrays: dict[str, NDArray[Any]] = {}
        for joint, cell in enumerate(cells):
            name, element = self._cells[cell]
            if name not in arrays:
                arrays = {name: _array(self._archive, self._entries[name], slice(first, last))}
            column = _column(arrays[name], element)
            channel[:, joint] = column[rows[first:last]] if is_part else column
        return channel

    def _check_length(self, name: str, samples: int) -> None:
        shape = self._entries[name].shape
        if shape[0] != samples:
            raise InputError(
                f"{self._path}: {name} has shape {shape}, time has {samples} samples; expected one row per sample; "
                "save it transposed or cut to the same length"
            )


@contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    if not starts_with(path, _ZIP_MAGIC):
        raise InputError(
            f"{path}: does not begin as a zip archive; expected one written by numpy.savez; save it again that way"
        )
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive
    except _DAMAGED as error:
        raise InputError(f"{path}: a damaged NumPy archive: {error}; copy or save it again") from error


def _entries(archive: zipfile.ZipFile, path: Path) -> tuple[dict[str, Entry], tuple[Finding, ...]]:
    """Return the arrays in an archive by name, and what is damaged; nothing is unpacked but headers."""
    entries: dict[str, Entry] = {}
    damage = []
    for info in archive.infolist():
        name = info.filename.removesuffix(".npy")
        if name == info.filename:
            continue
        try:
            entry = _entry(archive, info)
        except _DAMAGED as error:
            message = f"array {name!r} is damaged and left out ({error})"
            damage.append(Finding(code="damaged_numbers", message=message, damaged=True))
            continue
        if entry.dtype.hasobject:
            raise InputError(
                f"{path}: array {name!r} is pickled, which could run foreign code when it is read; save plain arrays: "
                "numpy.savez(file, **{name: numpy.asarray(values, dtype=float) for name, values in log.items()})"
            )
        if entry.shape:
            entries[name] = entry
    return entries, tuple(damage)


def _entry(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Entry:
    """Read the header of an array.

    Raises:
        ValueError: If it is none, or claims another size than the entry has.
    """
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError("compressed in another way than NumPy does")
    with archive.open(info) as stream:
        version = npy.read_magic(stream)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, by_column, dtype = read(stream)
        entry = Entry(info=info, shape=shape, by_column=by_column, dtype=dtype, offset=stream.tell())
    if not dtype.itemsize or (not dtype.hasobject and entry.offset + prod(shape) * dtype.itemsize != info.file_size):
        raise ValueError(f"shape {shape} of {dtype} in {info.file_size} bytes")
    return entry


def _joint_names(archive: zipfile.ZipFile, entries: Mapping[str, Entry]) -> list[str]:
    named = entries.get("joint_names")
    if named is None or named.dtype.kind != "U" or named.info.file_size > _NAMES_BYTES:
        return []
    return [str(name) for name in _array(archive, named).ravel()]


def _array(archive: zipfile.ZipFile, entry: Entry, rows: slice = slice(None)) -> NDArray[Any]:
    """Return some rows of an array, (n,) or (n, k); all of it goes by, so that its checksum is verified."""
    samples, width = entry.shape[0], entry.width
    first, last, _ = rows.indices(samples)
    runs = [(c * samples + first, c * samples + last) for c in range(width)]
    runs = runs if entry.by_column else [(first * width, last * width)]
    numbers = np.empty((last - first) * width, dtype=entry.dtype)
    place, filled = 0, 0
    with archive.open(entry.info) as stream:
        _skip(stream, entry.offset)
        for start, stop in runs:
            _skip(stream, (start - place) * entry.dtype.itemsize)
            _fill(stream, numbers[filled : filled + stop - start])
            place, filled = stop, filled + stop - start
        while stream.read(_CHUNK_BYTES):
            pass
    return numbers.reshape((last - first, width), order="F" if entry.by_column else "C")


def _skip(stream: IO[bytes], size: int) -> None:
    while size > 0:
        chunk = stream.read(min(size, _CHUNK_BYTES))
        if not chunk:
            raise EOFError("the archive ends within an array")
        size -= len(chunk)


def _fill(stream: IO[bytes], numbers: NDArray[Any]) -> None:
    target = numbers.view(np.uint8)
    while len(target):
        chunk = stream.read(min(len(target), _CHUNK_BYTES))
        if not chunk:
            raise EOFError("the archive ends within an array")
        target[: len(chunk)] = np.frombuffer(chunk, dtype=np.uint8)
        target = target[len(chunk) :]


def _column(array: NDArray[Any], element: int | None) -> NDArray[Any]:
    return array[:, element or 0]


def _recognises(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.endswith(".npy") for name in archive.namelist())
    except _DAMAGED:
        return path.is_file() and path.suffix.lower() == ".npz" and starts_with(path, _ZIP_MAGIC)


def _tables(path: Path) -> tuple[Topic, ...]:
    with _opened(path) as archive:
        entries, _ = _entries(archive, path)
    return tuple(
        Topic(name=name, type=f"array {entry.shape} {entry.dtype}", messages=entry.shape[0], readable=True)
        for name, entry in entries.items()
    )


NPZ = Reader(
    name="npz",
    suffixes=(".npz",),
    recognises=_recognises,
    read=read_npz,
    topics=_tables,
    summary="NumPy archives: panda-py's get_log(), or arrays (n, joints) under house names",
)
