"""TidyTable -> CSV, Parquet, or a pandas frame: the same rows and columns in each, joint and name in front."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.export.write_columns import arrow_types
from friction_audit.printable import csv_text, encodable
from friction_audit.tidy_table import Column, TidyTable

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

HEAD: dict[str, type] = {"joint": int, "name": str}
"""Columns that every table begins with."""


def write_table_csv(table: TidyTable, path: Path) -> None:
    """Write a table as CSV; numbers in the shortest form that reads back to the bit, an empty cell for none."""
    from pyarrow import csv

    with csv.CSVWriter(path, _schema(table)) as writer:
        for batch in _batches(table, csv_text):
            writer.write_batch(batch)


def write_table_parquet(table: TidyTable, path: Path) -> None:
    """Write a table as Parquet, a row group per joint."""
    import pyarrow.parquet as pq

    with pq.ParquetWriter(path, _schema(table), compression="zstd") as writer:
        for batch in _batches(table):
            writer.write_batch(batch)


def to_frame(table: TidyTable) -> "pd.DataFrame":
    """Return a table as a pandas frame; NaN or None where there is nothing."""
    import pyarrow as pa

    frame: pd.DataFrame = pa.Table.from_batches(_batches(table), _schema(table)).to_pandas()
    return frame


def _schema(table: TidyTable) -> "pa.Schema":
    import pyarrow as pa

    kinds = arrow_types()
    return pa.schema([(name, kinds[kind]) for name, kind in (HEAD | dict(table.types)).items()])


def _batches(table: TidyTable, write_text: Callable[[str], str] = encodable) -> "Iterator[pa.RecordBatch]":
    import pyarrow as pa

    schema = _schema(table)
    for rows in table.rows:
        if len(rows):
            head = [
                pa.repeat(pa.scalar(rows.joint, pa.int64()), len(rows)),
                pa.repeat(write_text(rows.name), len(rows)),
            ]
            columns = [_array(rows.columns[name], schema.field(name).type, write_text) for name in table.types]
            yield pa.record_batch([*head, *columns], schema=schema)


def _array(column: Column, kind: "pa.DataType", write_text: Callable[[str], str]) -> "pa.Array":
    import pyarrow as pa

    if pa.types.is_string(kind):
        return pa.array([None if text is None else write_text(text) for text in column], type=kind)
    return pa.array(column, type=kind, from_pandas=True)
