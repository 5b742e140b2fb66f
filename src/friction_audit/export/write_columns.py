"""A table of results -> Parquet, lot by lot: of a long one no more than a lot is in memory."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa


def write_columns(lots: Iterable[Mapping[str, Sequence[Any]]], types: Mapping[str, type], path: Path) -> None:
    """Write columns of numbers, words and flags, None where there is nothing.

    Args:
        lots: Columns by name, all of one length; of the rows that follow, the same columns.
        types: What is in each: ``str``, ``int``, ``float`` or ``bool``.
        path: Where to.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = arrow_types()
    schema = pa.schema([(name, kinds[kind]) for name, kind in types.items()])
    with pq.ParquetWriter(path, schema, compression="zstd", write_page_checksum=True) as writer:
        for columns in lots:
            writer.write_table(pa.table(dict(columns), schema=schema))


def arrow_types() -> "dict[type, pa.DataType]":
    """Return what Arrow calls the kinds of columns."""
    import pyarrow as pa

    return {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
