"""Tables as CSV, Parquet and frames: the same, whatever is in them."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from friction_audit.io.tidy_table import JointRows, TidyTable
from friction_audit.io.writers.tables import to_frame, write_table

NAMES = ('a,"b"\n', "knee \udce9")


def table(rows: tuple[JointRows, ...] | None = None) -> TidyTable:
    made = tuple(
        JointRows(
            joint=number,
            name=name,
            columns={
                "stop_s": np.array([0.1, 1 / 3]),
                "energy_j": np.array([np.nan, 2.0]),
                "cycle": np.array([1.0, 2.0]),
                "steps": [None, 7],
                "open": np.array([True, False]),
                "left_out": ["", "gap"],
            },
        )
        for number, name in enumerate(NAMES, start=2)
    )
    return TidyTable(
        name="cycles",
        summary="a cycle",
        types={"stop_s": float, "energy_j": float, "cycle": int, "steps": int, "open": bool, "left_out": str},
        time="stop_s",
        rows=made if rows is None else rows,
    )


def test_a_frame_has_joint_and_name_in_front() -> None:
    frame = to_frame(table())
    assert list(frame.columns[:3]) == ["joint", "name", "stop_s"]
    assert list(frame["joint"]) == [2, 2, 3, 3]
    assert frame["name"][2] == "knee \\udce9"
    assert list(frame["stop_s"][:2]) == [0.1, 1 / 3]
    assert list(frame["energy_j"].isna()) == [True, False, True, False]
    assert frame["cycle"].dtype == np.int64
    assert frame["open"].dtype == np.bool_


def test_csv_and_parquet_read_back_to_the_bit(tmp_path: Path) -> None:
    write_table(table(), tmp_path / "cycles.csv", "csv")
    write_table(table(), tmp_path / "cycles.parquet", "parquet")
    frame = to_frame(table())
    pd.testing.assert_frame_equal(pq.read_table(tmp_path / "cycles.parquet").to_pandas(), frame, check_exact=True)
    again = pd.read_csv(tmp_path / "cycles.csv", keep_default_na=False, na_values={"energy_j": [""], "steps": [""]})
    pd.testing.assert_frame_equal(again, frame, check_exact=True, check_dtype=False)


def test_a_table_without_rows_keeps_its_columns(tmp_path: Path) -> None:
    write_table(table(()), tmp_path / "none.csv", "csv")
    write_table(table(()), tmp_path / "none.parquet", "parquet")
    assert list(pd.read_csv(tmp_path / "none.csv").columns) == list(to_frame(table()).columns)
    assert pq.read_table(tmp_path / "none.parquet").num_rows == 0
