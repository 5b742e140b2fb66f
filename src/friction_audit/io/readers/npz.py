"""NumPy .npz -> Recording: panda-py's ``get_log()`` as people save it, or arrays under names of channels."""

import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.lib import format as npy

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.arrays import ArrayTable, topics_of
from friction_audit.io.readers.clocks import TimeColumn
from friction_audit.io.readers.columns import ColumnMap
from friction_audit.io.readers.reader import ReadOptions, Topic
from friction_audit.io.readers.table import Cells, Piece, Pieces, Rows, read_table
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding

_PANDA_PY = {"O_T_EE", "control_command_success_rate", "time"}
_PANDA_PY_CLOCK = TimeColumn(cells=(), name="time", unit="ms", clock="robot_time")
_ZIP_MAGIC = b"PK"
_NAMES_BYTES = 1 << 20
_BLOCK_ROWS = 1 << 16
# What NumPy and the zip module raise on a damaged archive.
_DAMAGED = (zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError, SyntaxError, OSError, EOFError,
            LookupError, OverflowError, ValueError, RuntimeError)  # fmt: skip


class Entry(NamedTuple):
    """An array in the archive, by what its header says: ``offset`` is the header's length in bytes."""

    info: zipfile.ZipInfo
    shape: tuple[int, ...]
    width: int  # numbers per row
    dtype: np.dtype[Any]
    nbytes: int  # in the file
    by_column: bool
    offset: int


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a NumPy archive."""
    with _opened(path) as archive:
        return read_table(NpzTable(path, archive), options)


class NpzTable(ArrayTable):
    """The arrays of an archive; pickled ones are never unpacked."""

    may_be_long = False

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        entries, damage = _entries(archive, path)
        self._entries = {name: entry for name, entry in entries.items() if entry.dtype.kind in "fiu"}
        super().__init__(path, self._entries, damage)
        named = entries.get("joint_names")
        if named is not None and named.dtype.kind == "U" and named.info.file_size <= _NAMES_BYTES:
            self.joint_names = [str(name) for _, part in _pieces(archive, named) for name in part.ravel()]
        wide = {name for name, entry in self._entries.items() if entry.width == len(self.joint_names) > 1}
        self.labels = {cell: self.joint_names[j] for cell, (name, j) in enumerate(self.arrays) if name in wide}
        self.clock = _PANDA_PY_CLOCK if self._entries.keys() >= _PANDA_PY else None

    def in_blocks(self, columns: ColumnMap) -> tuple[int, Pieces] | None:
        """Read pieces of all arrays side by side; None where one lies in the file column after column."""
        entries = [self._entries[self.arrays[cell][0]] for cell in columns.cells]
        return None if any(entry.by_column for entry in entries) else (entries[0].shape[0], self._side_by_side)

    def _side_by_side(self, cells: Sequence[int]) -> Iterator[Cells]:
        names = list(dict.fromkeys(self.arrays[cell][0] for cell in cells))
        with _opened(self.path) as archive:
            for pieces in zip(*(_pieces(archive, self._entries[name]) for name in names), strict=True):
                arrays = {name: array for name, (_, array) in zip(names, pieces, strict=True)}
                yield {cell: arrays[self.arrays[cell][0]][:, self.arrays[cell][1]] for cell in cells}

    def pieces(self, columns: ColumnMap, name: str, rows: Rows) -> Iterator[Piece]:  # noqa: ARG002
        with _opened(self.path) as archive:
            yield from _pieces(archive, self._entries[name])


@contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    if not starts_with(path, _ZIP_MAGIC):
        raise InputError(f"{path}: does not begin as a zip archive; expected one by numpy.savez; save it that way")
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive
    except _DAMAGED as error:
        raise InputError(f"{path}: a damaged NumPy archive: {error}; copy or save it again") from error


def _entries(archive: zipfile.ZipFile, path: Path) -> tuple[dict[str, Entry], tuple[Finding, ...]]:
    """Return the arrays in an archive by name, and what is damaged; nothing is unpacked but headers."""
    entries, damage = dict[str, Entry](), list[Finding]()
    for info in archive.infolist():
        name = info.filename.removesuffix(".npy")
        if name == info.filename:
            continue
        try:
            entry = _entry(archive, info)
        except _DAMAGED as error:
            text = f"array {name!r} is damaged and left out ({error})"
            damage.append(Finding("damaged_numbers", text, damaged=True))
            continue
        if entry.dtype.hasobject:
            what = f"array {name!r} is pickled, which could run foreign code"
            raise InputError(f"{path}: {what}; save plain arrays of numbers with numpy.savez")
        if entry.shape:
            entries[name] = entry
    return entries, tuple(damage)


def _entry(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Entry:
    """Read the header of an array; ValueError if it is none, or claims another size than the entry has."""
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError("compressed in another way than NumPy does")
    with archive.open(info) as stream:
        read = npy.read_array_header_1_0 if npy.read_magic(stream) == (1, 0) else npy.read_array_header_2_0
        shape, by_column, dtype = read(stream)
        sizes = {"width": prod(shape[1:]), "nbytes": info.compress_size, "offset": stream.tell()}
        entry = Entry(info=info, shape=shape, dtype=dtype, by_column=by_column, **sizes)
    if not dtype.itemsize or (not dtype.hasobject and entry.offset + prod(shape) * dtype.itemsize != info.file_size):
        raise ValueError(f"shape {shape} of {dtype} in {info.file_size} bytes")
    return entry


def _pieces(archive: zipfile.ZipFile, entry: Entry) -> Iterator[Piece]:
    """Yield an array as it lies in the file; ValueError where it ends early."""
    width = 1 if entry.by_column else entry.width
    with archive.open(entry.info) as stream:
        stream.read(entry.offset)
        for column in range(0, entry.width, width or 1):
            for first in range(0, entry.shape[0], _BLOCK_ROWS):
                rows = min(_BLOCK_ROWS, entry.shape[0] - first)
                content = stream.read(rows * width * entry.dtype.itemsize)
                yield column, np.frombuffer(content, entry.dtype).reshape(rows, width)
        stream.read(1)  # which verifies the checksum


def recognises(path: Path) -> bool:
    """Return True for an archive with NumPy arrays."""
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.endswith(".npy") for name in archive.namelist())
    except _DAMAGED:
        return path.is_file() and path.suffix.lower() == ".npz" and starts_with(path, _ZIP_MAGIC)


def topics(path: Path) -> tuple[Topic, ...]:
    """List the arrays of an archive."""
    with _opened(path) as archive:
        return topics_of(_entries(archive, path)[0])
