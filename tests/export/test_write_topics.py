"""Tables as CSV, Parquet, frames and topics of an MCAP: the same, read back by the libraries."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader

from friction_audit.io.writers.mcap import write_topics
from friction_audit.io.writers.tables import UNKNOWN_START_NS, JointRows, TidyTable, stamps_ns, to_frame, write_table
from friction_audit.joint_log import JointLog, Source

START_S = 1_700_000_000.25


def log(start_s: float | None = START_S) -> JointLog:
    t = np.linspace(0.0, 10.0, 1001)
    q = np.zeros((len(t), 1))
    source = Source(path="run.csv", sha256="0" * 64, format="csv", start_s=start_s)
    return JointLog(t=t, q=q, dq=q.copy(), tau_J=q.copy(), joint_names=("elbow",), source=source)


def tables() -> tuple[TidyTable, ...]:
    cycles = {"stop_s": np.array([2.0, 10.0]), "energy_j": np.array([1.5, np.nan]), "left_out": ["", "gap"]}
    words: dict[str, Any] = {"verdict": ["none"], "cycles": [None]}
    signal = {"time_s": np.arange(3) * 4.0, "torque_nm": np.array([0.1, 0.2, 0.3])}
    return (
        made("cycles", {"stop_s": float, "energy_j": float, "left_out": str}, "stop_s", cycles),
        made("verdicts", {"verdict": str, "cycles": int}, None, words),
        made("interaction", {"time_s": float, "torque_nm": float}, "time_s", signal),
        TidyTable(name="effects", summary="", types={"effect": str}, time=None, rows=()),
    )


def made(
    name: str, types: dict[str, type], time: str | None, columns: dict[str, Any], joints: tuple[str, ...] = ("elbow",)
) -> TidyTable:
    rows = tuple(JointRows(joint=number, name=joint, columns=columns) for number, joint in enumerate(joints, start=4))
    return TidyTable(name=name, summary=f"of {name}", types=types, time=time, rows=rows)


def messages(path: Path) -> list[tuple[Any, Any, Any]]:
    with path.open("rb") as stream:
        return list(make_reader(stream, validate_crcs=True).iter_messages())


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "estimate.mcap"
    write_topics(tables(), log(), path)
    return path


def test_every_row_is_a_message_of_its_schema(written: Path) -> None:
    found = messages(written)
    assert sorted({channel.topic for _, channel, _ in found}) == [
        f"/friction_audit/joint_4/{name}" for name in ("cycles", "interaction", "verdicts")
    ]
    for schema, channel, message in found:
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        assert channel.metadata == {"joint": "4", "joint_name": "elbow"}
        described = json.loads(schema.data)
        jsonschema.Draft202012Validator.check_schema(described)
        jsonschema.validate(json.loads(message.data), described | {"additionalProperties": False})
    cycles = [json.loads(one.data) for _, channel, one in found if channel.topic.endswith("/joint_4/cycles")]
    assert cycles == [{"stop_s": 2.0, "energy_j": 1.5, "left_out": ""}, {"stop_s": 10.0, "left_out": "gap"}]


def test_stamps_are_the_log_s_clock(written: Path) -> None:
    found = messages(written)
    stamps = stamps_ns(log())
    assert [m.log_time for _, _, m in found] == sorted(m.log_time for _, _, m in found)
    assert all(stamps[0] <= m.log_time <= stamps[-1] for _, _, m in found)
    for name, at in {"cycles": [stamps[200], stamps[1000]], "verdicts": [stamps[1000]]}.items():
        assert [m.log_time for _, c, m in found if c.topic.endswith(f"/joint_4/{name}")] == at


DATED, BARE = int(stamps_ns(log())[0]), UNKNOWN_START_NS


@pytest.mark.parametrize(
    ("start_s", "window", "first", "last_s"),
    [
        (START_S, (1.995, 4.0), DATED + 2_000_000_000, 1.99),
        (None, (1.995, 4.0), BARE + 2_000_000_000, 1.99),
        *((None, (start, None), BARE, 10.0) for start in (None, 0.0, -5.0)),
    ],
)
def test_a_window_keeps_the_clock_and_nothing_lies_outside_it(
    start_s: float | None, window: tuple[float | None, float | None], first: int, last_s: float, tmp_path: Path
) -> None:
    times = made("times", {"time_s": float}, "time_s", {"time_s": np.array([-0.1, 0.5, 99.0])})
    write_topics([times], log(start_s).take_window(*window), tmp_path / "part.mcap")
    found = [message.log_time - first for _, _, message in messages(tmp_path / "part.mcap")]
    assert found == [0, 500_000_000, round(last_s * 1e9)]


def test_no_rows_make_a_file_without_topics(tmp_path: Path) -> None:
    write_topics([tables()[0]._replace(rows=())], log(), tmp_path / "none.mcap")
    assert messages(tmp_path / "none.mcap") == []


NAMES = ('a,"b"\n', "knee \udce9")
TYPES = {"stop_s": float, "energy_j": float, "cycle": int, "steps": int, "open": bool, "left_out": str}
COLUMNS = {
    "stop_s": np.array([0.1, 1 / 3]), "energy_j": np.array([np.nan, 2.0]), "cycle": np.array([1.0, 2.0]),
    "steps": [None, 7], "open": np.array([True, False]), "left_out": ["", "gap"],
}  # fmt: skip
TABLE = made("cycles", TYPES, "stop_s", COLUMNS, NAMES)


def test_a_frame_has_joint_and_name_in_front() -> None:
    frame = to_frame(TABLE)
    assert list(frame.columns[:3]) == ["joint", "name", "stop_s"]
    assert list(frame["joint"]) == [4, 4, 5, 5]
    assert frame["name"][2] == "knee \\udce9"
    assert list(frame["stop_s"][:2]) == [0.1, 1 / 3]
    assert list(frame["energy_j"].isna()) == [True, False, True, False]
    assert frame["cycle"].dtype == np.int64
    assert frame["open"].dtype == np.bool_


def test_csv_and_parquet_read_back_to_the_bit(tmp_path: Path) -> None:
    for kind in ("csv", "parquet"):
        write_table(TABLE, tmp_path / f"cycles.{kind}", kind)
    frame = to_frame(TABLE)
    pd.testing.assert_frame_equal(pq.read_table(tmp_path / "cycles.parquet").to_pandas(), frame, check_exact=True)
    again = pd.read_csv(tmp_path / "cycles.csv", keep_default_na=False, na_values={"energy_j": [""], "steps": [""]})
    pd.testing.assert_frame_equal(again, frame, check_exact=True, check_dtype=False)


def test_a_table_without_rows_keeps_its_columns(tmp_path: Path) -> None:
    for kind in ("csv", "parquet"):
        write_table(TABLE._replace(rows=()), tmp_path / f"none.{kind}", kind)
    assert list(pd.read_csv(tmp_path / "none.csv").columns) == list(to_frame(TABLE).columns)
    assert pq.read_table(tmp_path / "none.parquet").num_rows == 0
