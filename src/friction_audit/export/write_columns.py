"""A table of results -> Parquet."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def write_columns(columns: Mapping[str, Sequence[Any]], types: Mapping[str, type], path: Path) -> None:
    """Write columns of numbers, words and flags, None where there is nothing.

    Args:
        columns: By name, all of one length.
        types: What is in each: ``str``, ``int``, ``float`` or ``bool``.
        path: Where to.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
    arrays = {name: pa.array(column, type=kinds[types[name]]) for name, column in columns.items()}
    pq.write_table(pa.table(arrays), path, compression="zstd")
