"""Columns of a result -> Parquet."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa


def write_columns_parquet(columns: Mapping[str, Sequence[Any]], types: Mapping[str, type], path: Path) -> None:
    """Write a table.

    Args:
        columns: Values by column, all of one length; None where there is none.
        types: What is in each column: str, int, float or bool; a column of nothing but None has a type all the same.
        path: Where to.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrow = _arrow_types()
    table = pa.table({name: pa.array(values, type=arrow[types[name]]) for name, values in columns.items()})
    pq.write_table(table, path, compression="zstd")


def _arrow_types() -> "dict[type, pa.DataType]":
    import pyarrow as pa

    return {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
