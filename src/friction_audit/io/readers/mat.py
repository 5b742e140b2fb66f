"""MATLAB .mat -> Recording: versions 5 to 7 by SciPy, 7.3 (HDF5) by h5py; fields of structures have dotted names."""

import struct
import zlib
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from math import prod
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.arrays import ArrayTable, topics_of
from friction_audit.io.readers.channel_names import parse_name
from friction_audit.io.readers.clocks import find_time
from friction_audit.io.readers.reader import ReadOptions, Topic, refuse_too_large
from friction_audit.io.readers.table import read_table
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding

_HDF5 = (b"MATLAB 7.3", b"\x89HDF")  # of MATLAB, and of scripts that write HDF5 under this name
_FEWEST_SAMPLES = 2
_HEADER_BYTES, _ORDER_BYTES = 128, slice(126, 128)
# Types of elements of version 5 (MAT-File Format, MathWorks, table 1-1).
_ELEMENTS, _MATRIX, _COMPRESSED = {*range(1, 8), 9, *range(12, 19)}, 14, 15
_DEEPEST = 10  # structures within structures
# What SciPy and h5py raise on a damaged file.
_DAMAGED = (ValueError, TypeError, LookupError, OSError, EOFError, OverflowError, AttributeError, NotImplementedError,
            RuntimeError, NameError, zlib.error, struct.error)  # fmt: skip


def read(path: Path, options: ReadOptions) -> Recording:
    """Read the variables of a MATLAB file."""
    return read_table(ArrayTable(path, *_arrays(path)), options)


def topics(path: Path) -> tuple[Topic, ...]:
    """List the arrays of a MATLAB file."""
    return topics_of(_arrays(path)[0])


def _arrays(path: Path) -> tuple[dict[str, NDArray[Any]], tuple[Finding, ...]]:
    """Return the arrays of numbers by name, one row per sample, and what is said of channels of another shape."""
    try:
        whole = dict(_from_hdf5(path) if any(starts_with(path, magic) for magic in _HDF5) else _from_version_5(path))
    except _DAMAGED as error:
        text = " ".join(str(error).split())
        raise InputError(f"{path}: a damaged MATLAB file: {text}; copy or save it again") from error
    sizes = {name: "x".join(map(str, array.shape)) for name, array in whole.items()}
    plain = {name: np.atleast_1d(np.squeeze(array)) for name, array in whole.items()}
    samples = max((max(array.shape) for array in plain.values() if array.ndim <= 2), default=0)  # noqa: PLR2004
    # Joints are columns in one half of all scripts, and rows in the other.
    turned = {name: array.T if array.shape[-1] == samples else array for name, array in plain.items()}
    found = {name: array for name, array in turned.items() if array.ndim <= 2 and len(array) == samples}  # noqa: PLR2004
    if samples < _FEWEST_SAMPLES or not found:
        held = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(
            f"{path}: no array of numbers with several samples; found {held or 'none'}; expected time, q, dq and a "
            "torque as arrays or fields of a structure; save them with save('log.mat', 't', 'q', 'dq', 'tau_J'), of "
            "objects such as timeseries and table their Time and Data"
        )
    others = [name for name in plain.keys() - found.keys() if parse_name(f"{name}[0]") or find_time([name])]
    text = ", ".join(f"{name} of {sizes[name]}" for name in sorted(others))
    message = f"left out: {text}; expected {samples} samples in every array, one row or column per joint"
    findings = (Finding("wrong_shape", message, amount=float(len(others))),) if others else ()
    heads = {name.rpartition(".")[0] for name in found}
    head = f"{heads.pop()}." if len(heads) == 1 else ""  # a structure that holds all arrays: log.q is q
    return {name.removeprefix(head): array for name, array in found.items()}, findings


def _from_version_5(path: Path) -> Iterator[tuple[str, NDArray[Any]]]:
    from scipy.io import loadmat, whosmat

    with path.open("rb") as stream, mmap(stream.fileno(), 0, access=ACCESS_READ) as content:
        if len(content) < _HEADER_BYTES:
            raise ValueError("it ends within its header")
        _check_elements(content, _HEADER_BYTES, len(content), ">" if content[_ORDER_BYTES] == b"MI" else "<")
    refuse_too_large(path, 8 * sum(prod(shape) for _, shape, _ in whosmat(str(path))), path.stat().st_size)
    variables = loadmat(str(path), simplify_cells=True)
    yield from _flat({name: value for name, value in variables.items() if not name.startswith("__")}, "")


def _check_elements(content: mmap, place: int, stop: int, order: str) -> None:
    """Refuse elements that SciPy ends the process at: of unknown types, or longer than what holds them."""
    while place + 8 <= stop:
        kind, size = struct.unpack_from(f"{order}II", content, place)
        is_small = kind >> 16 != 0  # type and size share four bytes, the content has the other four
        end = place + 8 + (0 if is_small else size)
        kind &= 0xFFFF
        if kind not in _ELEMENTS or end > stop:
            raise ValueError(f"an element of type {kind} and {size} bytes at byte {place}")
        if kind == _MATRIX:
            _check_elements(content, place + 8, end, order)
        place = end + (-end % 8 if kind != _COMPRESSED else 0)


def _flat(values: Mapping[str, Any], head: str) -> Iterator[tuple[str, NDArray[Any]]]:
    for name, value in values.items():
        if isinstance(value, Mapping) and head.count(".") < _DEEPEST:
            yield from _flat(value, f"{head}{name}.")
        elif isinstance(value, list | np.ndarray) and len(value) and isinstance(value[0], Mapping):
            yield from _flat({str(number): one for number, one in enumerate(value, 1)}, f"{head}{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and value.size:
            yield f"{head}{name}", value


def _from_hdf5(path: Path) -> Iterator[tuple[str, NDArray[Any]]]:
    if find_spec("h5py") is None:
        raise InputError(f"{path}: MATLAB 7.3 needs h5py: pip install 'friction-audit[hdf5]' (or save it with '-v7')")
    import h5py

    with h5py.File(path) as file:
        items: list[Any] = []
        file.visititems(lambda _, item: items.append(item))
        every = (item for item in items if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and item.size)
        named = [item for item in every if not item.name.startswith("/#")]
        numbers = [item for item in named if item.attrs.get("MATLAB_class") not in (b"char", b"cell")]
        refuse_too_large(path, 8 * sum(item.size for item in numbers), path.stat().st_size)
        for item in numbers:
            yield item.name.strip("/").replace("/", "."), item[()].T  # MATLAB's columns are HDF5's rows
