from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import friction_audit
from friction_audit.io.readers import ReadOptions, read_log
from tests.io.synthetic_recordings import motion, refused, tidy_frame


def write(path: Path, columns: dict[str, Any], **options: Any) -> Path:
    pq.write_table(pa.table(columns), path, **options)
    return path


def tidy(path: Path, samples: int = 300) -> Path:
    tidy_frame(samples).to_parquet(path)
    return path


def lists() -> dict[str, Any]:
    return {name: array.tolist() for name, array in motion(300).items()}


def typed(kind: pa.DataType) -> dict[str, Any]:
    return {name: column if name == "t" else pa.array(column, type=kind) for name, column in lists().items()}


def structs() -> dict[str, Any]:
    columns = lists()
    time = columns.pop("t")
    state = pa.array([dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)])
    return {"time": time, "robot_state": state}


def long() -> dict[str, Any]:
    arrays = motion(300)
    columns: dict[str, Any] = {"time": np.repeat(arrays.pop("t"), 3), "joint": ["joint1", "joint2", "joint3"] * 300}
    return columns | {"state": pa.StructArray.from_arrays([pa.array(a.ravel()) for a in arrays.values()], list(arrays))}


SAME: dict[str, Callable[[], dict[str, Any]]] = {
    "scalars": lambda: {str(name): column for name, column in tidy_frame(300).items()},
    "lists": lambda: typed(pa.list_(pa.float64())),
    "lists of one length": lambda: typed(pa.list_(pa.float64(), 3)),
    "large lists": lambda: typed(pa.large_list(pa.float64())),
    "structs of lists": structs,
    "a long table, its channels in a struct": long,
}


@pytest.mark.parametrize("columns", SAME.values(), ids=SAME)
def test_tables_that_are_read_to_the_bit(tmp_path: Path, columns: Callable[[], dict[str, Any]]) -> None:
    log = read_log(write(tmp_path / "run.parquet", columns(), row_group_size=64))
    for name, array in motion(300).items():
        np.testing.assert_array_equal(getattr(log, name), array)
    assert log.q.flags.f_contiguous
    assert (log.source.format, log.source.findings) == ("parquet", ())


def test_a_list_column_by_mapping(tmp_path: Path) -> None:
    names = {"q": "observation.state", "dq": "observation.speed", "tau_J": "observation.load"}
    path = write(tmp_path / "run.parquet", {names.get(name, name): column for name, column in lists().items()})
    np.testing.assert_array_equal(read_log(path, ReadOptions(mapping=names)).q, motion(300)["q"])


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (
            lambda: pd.DataFrame(lists() | {"dq": [*lists()["dq"][:200], [0.0], *lists()["dq"][201:]]}),
            "row 201 of dq holds 1 values; expected 3",
        ),
        (
            lambda: tidy_frame(300).assign(time=pd.to_datetime([None, *range(1, 300)], unit="ms")),
            "time lacks 1 stamps; expected one in every row",
        ),
        (lambda: tidy_frame(300).assign(dq_2="fast"), r"dq_2 holds (large_)?string"),
    ],
)
def test_columns_that_are_no_numbers_are_refused(tmp_path: Path, frame: Callable[[], pd.DataFrame], words: str) -> None:
    frame().to_parquet(tmp_path / "run.parquet")
    refused(words, read_log, tmp_path / "run.parquet")


@pytest.mark.parametrize("scalar", [True, False])
def test_missing_numbers_and_lists_are_rows_without_numbers(tmp_path: Path, scalar: bool) -> None:
    columns = {str(name): column.tolist() for name, column in tidy_frame(300).items()} if scalar else lists()
    columns["dq_2" if scalar else "dq"][200] = None
    log = read_log(write(tmp_path / "run.parquet", columns))
    assert [(f.code, f.amount) for f in log.source.findings if f.damaged] == [("non_finite", 1)]


def test_lists_that_begin_empty(tmp_path: Path) -> None:
    columns = {"name": [[], *[["a", "b", "c"]] * 299], **lists()}
    for channel in ("q", "dq", "tau_J"):
        columns[channel][0] = []
    log = read_log(write(tmp_path / "run.parquet", columns))
    np.testing.assert_array_equal(log.q, motion(300)["q"][1:])
    assert any(finding.damaged for finding in log.source.findings)


@pytest.mark.parametrize("unit", ["ms", "us", "ns", "integer ms"])
def test_stamps_of_any_unit_and_single_precision(tmp_path: Path, unit: str) -> None:
    time: Any = np.arange(300)
    if unit != "integer ms":
        time = pd.to_datetime(1_700_000_000_000 + time, unit="ms").as_unit(unit)
    tidy_frame(300).astype("float32").assign(time=time).to_parquet(tmp_path / "run.parquet")
    log = read_log(tmp_path / "run.parquet")
    assert log.q.dtype == np.float64
    np.testing.assert_array_equal(log.t, np.arange(300) / 1e3)
    assert log.source.start_s == (None if unit == "integer ms" else pytest.approx(1.7e9))
    assert log.source.channels["t"] == f"time [{unit.removeprefix('integer ')}]"


@pytest.mark.parametrize(
    ("metadata", "names", "robot"),
    [
        ({"joint_names": '["fr3_joint1", "fr3_joint2", "fr3_joint3"]'}, "fr3_joint1", "fr3"),
        ({"joint_names": '["a", "b", "c"]', "robot": "panda"}, "a", "panda"),
        ({"joint_names": '["a", "b", "c"]', "robot": "gen3"}, "a", "gen3"),
        ({"joint_names": '["a", "b"]', "robot": "toaster"}, "joint1", "unknown"),
        ({"joint_names": "[1, 2, 3]"}, "joint1", "unknown"),
        ({"joint_names": "no JSON"}, "joint1", "unknown"),
        ({"joint_names": "[" * 100_000}, "joint1", "unknown"),
    ],
)
def test_joints_named_in_the_metadata(tmp_path: Path, metadata: dict[str, str], names: str, robot: str) -> None:
    table = pa.Table.from_pandas(tidy_frame(300)).replace_schema_metadata(metadata)
    pq.write_table(table, tmp_path / "run.parquet")
    log = read_log(tmp_path / "run.parquet")
    assert (log.joint_names[0], log.source.robot) == (names, robot)


def test_damaged_in_the_middle(tmp_path: Path) -> None:
    path = tidy(tmp_path / "run.parquet", 5000)
    content = bytearray(path.read_bytes())
    content[4:4000] = bytes(3996)
    path.write_bytes(content)
    refused("a damaged Parquet file: time: row group 1 of 1", read_log, path)


def flip(path: Path, column: int, group: int) -> None:
    """Change a bit in the numbers of a column."""
    place = pq.ParquetFile(path).metadata.row_group(group).column(column)
    content = bytearray(path.read_bytes())
    content[place.data_page_offset + place.total_compressed_size - 40] ^= 4
    path.write_bytes(content)


@pytest.mark.parametrize("column", [0, 5], ids=["time", "dq_2"])
@pytest.mark.parametrize("stamps", ["float", "int"])
def test_a_changed_bit_costs_its_row_group(tmp_path: Path, column: int, stamps: str) -> None:
    frame = tidy_frame(300)
    if stamps == "int":
        frame["time"] = (frame["time"] * 1e9).round().astype(np.int64)
    path = tmp_path / "run.parquet"
    frame.to_parquet(path, row_group_size=100, write_page_checksum=True, compression=None, use_dictionary=False)
    flip(path, column, 1)
    log = read_log(path)
    np.testing.assert_array_equal(log.tau_J, np.delete(motion(300)["tau_J"], np.s_[100:200], axis=0))
    damage = next(finding for finding in log.source.findings if finding.code == "damaged_numbers")
    assert damage.damaged
    assert damage.message.startswith(f"{frame.columns[column]}: row group 2 of 3 is damaged")


def test_a_changed_bit_costs_its_joint_where_there_is_one_row_group(tmp_path: Path) -> None:
    path = tmp_path / "run.parquet"
    tidy_frame(300).to_parquet(path, write_page_checksum=True, compression=None, use_dictionary=False)
    flip(path, 5, 0)
    log = read_log(path)
    np.testing.assert_array_equal(log.q, motion(300)["q"][:, [0, 2]])
    assert any(finding.damaged and "dq_2" in finding.message for finding in log.source.findings)


def test_our_own_files_have_checksums(tmp_path: Path) -> None:
    for dialect in ("parquet", "parquet-lists"):
        path = tmp_path / f"{dialect}.parquet"
        friction_audit.write_log(read_log(tidy(tmp_path / "run.parquet", 5000)), path, dialect=dialect)
        flip(path, 1, 0)
        with pytest.raises(OSError, match="CRC"):
            pq.read_table(path, page_checksum_verification=True)


def test_claims_that_no_recording_makes_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.reader._BOMB_BYTES", 1_000_000)
    path = write(tmp_path / "bomb.parquet", dict.fromkeys(("time", "q_1", "dq_1", "tau_J_1"), np.zeros(100_000)))
    refused("GB packed into", read_log, path)


def test_a_log_beyond_memory_is_refused_with_a_way_to_a_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.reader.address_limit", lambda: 10_000)
    refused(r"memory here; read a part of it with .*--t-start 0 --t-end 600", read_log, tidy(tmp_path / "run.parquet"))
