"""The document of a batch keeps to its schema; the tidy table says the same, a row per session, joint, coefficient."""

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import pyarrow.parquet as pq
import pytest
from friction_audit.reporting.batch_summary import BatchSummary
from friction_audit.reporting.json.batch import batch_document, write_batch_document
from friction_audit.reporting.json.document import Document, write_document
from friction_audit.reporting.terminal.batch import COLUMNS, session_columns, write_session_csv

from friction_audit.io.writers.tables import write_columns
from friction_audit.reporting.html.batch_page import write_page
from friction_audit.reporting.schemas import load_schema
from friction_audit.reporting.terminal import batch as session_table
from tests.reporting import batch_by_hand as by_hand

ARM = by_hand.arm()
BATCHES = (by_hand.batch(ARM), by_hand.batch(by_hand.arm(2, 1, dated=False)), by_hand.hostile(), by_hand.empty())


def checked(summary: BatchSummary) -> Document:
    read: Document = json.loads("".join(write_batch_document(summary)))
    assert read == json.loads(write_document(batch_document(summary)))
    jsonschema.Draft202012Validator(load_schema("batch")).validate(read)
    return read


@pytest.mark.parametrize("summary", BATCHES, ids=("plain", "two sessions", "hostile", "empty"))
def test_documents_keep_to_the_schema(summary: BatchSummary) -> None:
    document = checked(summary)
    assert len(document["sessions"]) == len(summary.sessions)
    assert [one["path"] for one in document["failed"]] == [one.path for one in summary.failed]


def test_what_drifts_and_when() -> None:
    document = checked(by_hand.batch(ARM))
    by_joint = {joint["joint"]: joint for joint in document["joints"]}
    assert [joint for joint, one in by_joint.items() if one["drift"]] == [2, 5]
    assert by_joint[2]["change_points"] == [13]
    assert by_joint[1]["change_points"] == []
    assert by_joint[5]["coulomb_trend_nm_per_session"]["value"] == pytest.approx(0.00267)
    assert by_joint[7]["coulomb_trend_nm_per_session"] is None
    assert by_joint[7]["verdict"] == "not testable"
    coulomb = by_joint[2]["coefficients"]["coulomb_nm"]
    assert coulomb["change_points"][0]["ci95"] == [12, 14]
    assert [point["session"] for point in coulomb["control"] if point["outside"]] == list(range(13, 25))
    assert len(coulomb["values"]) == 23


def test_sessions_count_from_one_within_their_robot() -> None:
    document = checked(by_hand.batch(ARM, by_hand.arm(3, robot="panda-2")))
    assert [one["session"] for one in document["sessions"]] == [*range(1, 25), 1, 2, 3]
    assert [one["robot"] for one in document["robots"]] == ["panda-1", "panda-2"]
    assert document["robots"][0]["left_out"] == [{"session": 9, "reason": "payload 0.7 kg, the reference had none"}]
    assert document["robots"][0]["reference"] == [1, 2, 3, 4, 5]
    assert document["sessions"][1]["start"] == "2026-03-05T03:00:00.000Z"


def csv_text(summary: BatchSummary) -> str:
    text = io.StringIO()
    write_session_csv(summary, text)
    return text.getvalue()


def rows_of(summary: BatchSummary) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(csv_text(summary))))


def test_the_table_has_a_row_per_session_joint_and_coefficient() -> None:
    rows = rows_of(by_hand.batch(ARM))
    assert len(rows) == 24 * 7 * 2
    assert list(rows[0]) == list(COLUMNS)
    key = [(row["session"], row["joint"], row["coefficient"]) for row in rows]
    assert len(set(key)) == len(rows)


def test_a_row_says_what_the_session_says() -> None:
    rows = rows_of(by_hand.batch(ARM))
    (row,) = (r for r in rows if (r["session"], r["joint"], r["coefficient"]) == ("13", "2", "coulomb_nm"))
    value = ARM.sessions[12].joints[1].coefficients["coulomb_nm"]
    assert float(row["value"]) == pytest.approx(value.value)
    assert float(row["ci95_low"]) == pytest.approx(value.low)
    assert (row["outside"], row["compared"], row["reference"], row["note"]) == ("1", "1", "0", "after grease")
    (alone,) = (r for r in rows if (r["session"], r["joint"], r["coefficient"]) == ("9", "2", "coulomb_nm"))
    assert (alone["compared"], alone["compared_value"], alone["outside"]) == ("0", "", "")
    assert alone["left_out"].startswith("payload")
    (still,) = (r for r in rows if (r["session"], r["joint"], r["coefficient"]) == ("1", "7", "coulomb_nm"))
    assert (still["value"], still["unit"]) == ("", "N m")
    assert "does not move" in still["reason"]


@pytest.mark.usefixtures("sketched")
def test_a_name_that_no_encoding_knows_is_written_with_its_bytes(tmp_path: Path) -> None:
    sessions = (replace(ARM.sessions[0], path="r\udcff.csv"), *ARM.sessions[1:])
    summary = by_hand.batch(replace(ARM, sessions=sessions))
    assert rows_of(summary)[0]["path"] == "r\\udcff.csv"
    write_columns(session_columns(summary), COLUMNS, tmp_path / "sessions.parquet")
    assert "r\\udcff.csv" in write_page(summary)
    assert checked(summary)["sessions"][0]["path"] == "r\udcff.csv"


def test_a_table_of_nothing_has_its_head() -> None:
    assert csv_text(by_hand.empty()) == ",".join(COLUMNS) + "\n"


@pytest.mark.parametrize("summary", BATCHES, ids=("plain", "two sessions", "hostile", "empty"))
def test_parquet_holds_the_same(summary: BatchSummary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_table, "ROWS_AT_ONCE", 100)
    lots = list(session_columns(summary))
    path = tmp_path / "sessions.parquet"
    write_columns(lots, COLUMNS, path)
    table = pq.read_table(path)
    assert pq.ParquetFile(path).num_row_groups == len(lots) == -(-len(table) // 100)
    assert table.to_pydict() == {name: [cell for lot in lots for cell in lot[name]] for name in COLUMNS}
    types = {str: "string", int: "int64", float: "double", bool: "bool"}
    assert {field.name: str(field.type) for field in table.schema} == {n: types[t] for n, t in COLUMNS.items()}
