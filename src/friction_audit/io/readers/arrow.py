"""Columns of Arrow as arrays of NumPy, and what their types are."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from friction_audit.joint_log import Bool

KINDS = {
    "stamp": (pa.types.is_timestamp, pa.types.is_duration),  # whose type names the unit
    "list": (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list),
    "number": (pa.types.is_floating, pa.types.is_integer, pa.types.is_decimal),
    "text": (pa.types.is_string, pa.types.is_large_string, pa.types.is_string_view),
}


def flat(table: pa.Table | pa.RecordBatch) -> pa.Table:
    """Return a table with the fields of structs as columns of dotted names."""
    found = table if isinstance(table, pa.Table) else pa.Table.from_batches([table])
    while any(pa.types.is_struct(field.type) for field in found.schema):
        found = found.flatten()
    return found


def whole(column: pa.ChunkedArray) -> pa.Array:
    """Return a column of a batch in one piece; Arrow's own function copies one that is."""
    return column.chunk(0) if column.num_chunks == 1 else column.combine_chunks()


def are_the_same(texts: pa.Array, joints: Sequence[str]) -> Bool:
    """Return for each row of joint names, given one after the other, whether they are these."""
    coded = (texts.dictionary_decode() if pa.types.is_dictionary(texts.type) else texts).dictionary_encode()
    codes = {text: code for code, text in enumerate(coded.dictionary.to_pylist())}
    expected = [codes.get(joint, -1) for joint in joints]
    rows = coded.indices.to_numpy(zero_copy_only=False).reshape(-1, len(joints))
    return np.asarray((rows == expected).all(axis=1))


def integers_or_floats(array: pa.Array) -> NDArray[Any]:
    """Return Arrow numbers as NumPy: stamps as int64, everything else as it is, NaN for null."""
    if is_of(array.type, "stamp"):
        array = array.cast(pa.int64())
    if pa.types.is_decimal(array.type) or pa.types.is_boolean(array.type):
        array = array.cast(pa.float64())
    # Arrow's own conversion loads pandas, half a second, which only nulls need.
    return np.asarray(array.to_numpy(zero_copy_only=False) if array.null_count else np.from_dlpack(array))


def is_of(kind: pa.DataType, what: str) -> bool:
    """Return whether a type is one of KINDS; text may be in a dictionary."""
    inner = kind.value_type if what == "text" and pa.types.is_dictionary(kind) else kind
    return any(is_one(inner) for is_one in KINDS[what])
