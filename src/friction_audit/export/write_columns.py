"""A table of results -> Parquet."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa


def write_columns(columns: Mapping[str, Sequence[Any]], types: Mapping[str, type], path: Path) -> None:
    """Write columns of numbers, words and flags, None where there is nothing.

    Args:
        columns: By name, all of one length.
        types: What is in each: ``str``, ``int``, ``float`` or ``bool``.
        path: Where to.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = arrow_types()
    arrays = {name: pa.array(column, type=kinds[types[name]]) for name, column in columns.items()}
    pq.write_table(pa.table(arrays), path, compression="zstd")


def arrow_types() -> "dict[type, pa.DataType]":
    """Return what Arrow calls the kinds of columns."""
    import pyarrow as pa

    return {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
