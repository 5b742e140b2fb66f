"""NumPy .npy -> Recording: one array of shape (samples, columns), or of records with named fields."""

from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.arrays import ArrayTable
from friction_audit.io.readers.reader import ReadOptions, Topic
from friction_audit.io.readers.table import read_table
from friction_audit.io.recording import Recording

_PLANE = 2


def recognises(path: Path) -> bool:
    """Return True if the file begins as an array of NumPy does."""
    return starts_with(path, b"\x93NUMPY")


def read(path: Path, options: ReadOptions) -> Recording:
    """Read an array whose columns ``--map`` names by number, or whose fields have names."""
    array = _array(path)
    if array.dtype.names:
        return read_table(ArrayTable(path, {name: array[name] for name in array.dtype.names}), options)
    samples, width = array.shape
    if not options.mapping:
        raise InputError(
            f"{path}: an array of {samples} rows and {width} columns without names; expected to know what is in them; "
            "name the columns by number, e.g. --map t=#1 --map q=#2-#8 --map dq=#9-#15 --map tau_J=#16-#22"
        )
    return read_table(ArrayTable(path, {f"#{column + 1}": array[:, column] for column in range(width)}), options)


def topics(path: Path) -> tuple[Topic, ...]:
    """List the one array of the file."""
    array = _array(path)
    return (Topic(name=path.name, type=f"array {array.shape} {array.dtype}", messages=len(array), readable=True),)


def _array(path: Path) -> NDArray[Any]:
    """Map the array into memory: only the columns that are asked for are read."""
    try:
        array: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, OSError, EOFError, OverflowError, SyntaxError, TokenError) as error:
        if "allow_pickle" in str(error) or "Python objects" in str(error):
            raise InputError(
                f"{path}: Python objects, which could run foreign code when they are read; expected an array of "
                "numbers; save a dictionary of arrays with numpy.savez(file, **log)"
            ) from error
        raise InputError(f"{path}: a damaged NumPy array: {error}; copy or save it again") from error
    is_plane = array.ndim == _PLANE and array.dtype.kind in "fiu"
    if not array.size or not (array.ndim == 1 if array.dtype.names else is_plane):
        raise InputError(
            f"{path}: an array of shape {array.shape} {array.dtype}; expected numbers of shape (samples, columns); "
            "stack the signals with numpy.column_stack and save that, or save them by name with numpy.savez"
        )
    if array.dtype.names is None and array.shape[0] < array.shape[1]:
        raise InputError(
            f"{path}: {array.shape[0]} rows, {array.shape[1]} columns; expected one row per sample; save the transpose"
        )
    return array
