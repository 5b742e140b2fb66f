"""Columns of Arrow as arrays of NumPy, and what their types are."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray


def flat(table: pa.Table | pa.RecordBatch) -> pa.Table:
    """Return a table with the fields of structs as columns of dotted names."""
    found = table if isinstance(table, pa.Table) else pa.Table.from_batches([table])
    while any(pa.types.is_struct(field.type) for field in found.schema):
        found = found.flatten()
    return found


def whole(column: pa.ChunkedArray) -> pa.Array:
    """Return a column of a batch in one piece; Arrow's own function copies one that is."""
    return column.chunk(0) if column.num_chunks == 1 else column.combine_chunks()


def are_the_same(texts: pa.Array, joints: Sequence[str]) -> NDArray[np.bool_]:
    """Return for each row of joint names, given one after the other, whether they are these."""
    coded = (texts.dictionary_decode() if pa.types.is_dictionary(texts.type) else texts).dictionary_encode()
    codes = {text: code for code, text in enumerate(coded.dictionary.to_pylist())}
    expected = [codes.get(joint, -1) for joint in joints]
    rows = coded.indices.to_numpy(zero_copy_only=False).reshape(-1, len(joints))
    return np.asarray((rows == expected).all(axis=1))


def integers_or_floats(array: pa.Array) -> NDArray[Any]:
    """Return Arrow numbers as NumPy: stamps as int64, everything else as it is, NaN for null."""
    if has_unit(array.type):
        array = array.cast(pa.int64())
    if pa.types.is_decimal(array.type) or pa.types.is_boolean(array.type):
        array = array.cast(pa.float64())
    # Arrow's own conversion loads pandas, half a second, which only nulls need.
    return np.asarray(array.to_numpy(zero_copy_only=False) if array.null_count else np.from_dlpack(array))


def has_unit(kind: pa.DataType) -> bool:
    """Return whether numbers are stamps or durations, whose type names the unit."""
    return bool(pa.types.is_timestamp(kind) or pa.types.is_duration(kind))


def is_list(kind: pa.DataType) -> bool:
    """Return whether rows are lists."""
    return bool(pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind))


def is_number(kind: pa.DataType) -> bool:
    """Return whether rows are numbers."""
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind))


def is_text(kind: pa.DataType) -> bool:
    """Return whether rows are text."""
    inner = kind.value_type if pa.types.is_dictionary(kind) else kind
    return bool(pa.types.is_string(inner) or pa.types.is_large_string(inner) or pa.types.is_string_view(inner))
