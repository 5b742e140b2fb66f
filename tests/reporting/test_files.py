"""Tables for files: what is in them, by hand and against the results themselves."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from friction_audit.io.writers.tables import TidyTable, write_rows
from friction_audit.reporting import drift_sessions
from friction_audit.reporting.diagnosis import DIAGNOSE
from friction_audit.reporting.drift import BatchSummary
from friction_audit.reporting.drift_sessions import session_columns
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.replay import REPLAY
from friction_audit.reporting.report import LogReport, report_tables
from tests.reporting import batch_by_hand, diagnosis_by_hand, log_report_by_hand as by_hand
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import AMBIGUOUS, NAMED
from tests.reporting.test_documents import ARM, BATCHES
from tests.reporting.test_text import in_ampere

UNITLESS = {
    "condition_number", "correlation", "dissipation_removed", "dissipation_removed_updated", "limited_fraction",
    "active_fraction", "shrink", "omnibus_p_value", "remaining_p_value", "p_value", "value", "ci95_low", "ci95_high",
    "centre", "friction_share", "residual_share", "share_explained_without_gravity", "remainder_share", "share",
    "frequency",
}  # fmt: skip
"""Numbers that are shares and the like; of an effect's numbers the name of the number tells the unit."""
UNIT = re.compile(r"_(s|rad|rad_s|nm|nm_s|nms_per_rad|j)$")


TABLES = tuple(table.name for document in (ESTIMATE, REPLAY, DIAGNOSE) for table, _ in document.files)


@cache
def every() -> dict[str, TidyTable]:
    return {table.name: table for table in report_tables(by_hand.report())}


@pytest.mark.parametrize("name", TABLES)
def test_columns_are_complete_of_their_kind_and_name_their_units(name: str) -> None:
    table = every()[name]
    floats = [column for column, kind in table.types.items() if kind is float]
    assert [column for column in floats if not (UNIT.search(column) or column in UNITLESS)] == []
    for rows in table.rows:
        assert list(rows.columns) == list(table.types)
        assert len({len(column) for column in rows.columns.values()}) == 1
        for column, kind in table.types.items():
            found = {type(value) for value in np.asarray(rows.columns[column], dtype=object)}
            assert found <= {kind, float, np.float64, type(None)} if kind is int else found <= {kind}, column


def test_columns_are_the_result_s() -> None:
    found = by_hand.report()
    assert tuple(every()) == TABLES
    alone = LogReport(estimate=found.estimate)
    assert tuple(table.name for table in report_tables(alone)) == TABLES[: len(ESTIMATE.files)]
    for rows, joint in zip(every()["coefficients"].rows, found.estimate.friction.joints, strict=True):
        assert (rows.joint, rows.name, bool(rows.columns["reason"][0])) == (joint.joint, joint.name, bool(joint.reason))
        assert rows.columns["viscous_high_nms_per_rad"][0] == pytest.approx(joint.viscous.high, nan_ok=True)
    for column, rows in enumerate(every()["cycles"].rows):
        own = found.estimate.cycles[column]
        assert np.sum(rows.columns["net_energy_j"]) == pytest.approx(own.sums.work_j.sum())


@pytest.mark.parametrize(("unit", "ends"), [("N m", ("nm", "j")), ("A", ("a", "a_rad")), ("mA", ("ma", "ma_rad"))])
def test_columns_have_the_unit_of_the_torque(unit: str, ends: tuple[str, str]) -> None:
    coefficients, _, cycles, interaction = ESTIMATE.tables(in_ampere(build_estimate(1), unit))
    assert {f"coulomb{part}_{ends[0]}" for part in ("", "_low", "_high")} < coefficients.types.keys()
    assert f"net_energy_{ends[1]}" in cycles.types
    assert f"interaction_{ends[0]}" in interaction.types


def test_residual_is_measured_less_model_and_effects_are_words() -> None:
    """Half a newton metre, of which the nominal model has 0.4 and the augmented one 0.48."""
    whole = np.ones_like(NAMED.traces.measured)  # type: ignore[union-attr]
    effect = replace(AMBIGUOUS.effects[0], alternatives=("asymmetric_coulomb", "inertia_error"))
    traces = replace(NAMED.traces, measured=0.5 * whole, before=0.4 * whole, after=0.48 * whole)  # type: ignore[type-var]
    tables = DIAGNOSE.tables(diagnosis_by_hand.diagnosis(replace(NAMED, traces=traces, effects=(effect,))))
    made = {table.name: table.rows[0].columns for table in tables if table.rows}
    for name, value in {"nominal": 0.4, "augmented": 0.48, "residual_before": 0.1, "residual_after": 0.02}.items():
        assert made["residual"][f"{name}_nm"] == pytest.approx(value)
    assert list(made["effects"]["alternatives"]) == ["asymmetric_coulomb inertia_error"]


def sessions_of(summary: BatchSummary, path: Path) -> pd.DataFrame:
    for kind in ("csv", "parquet"):
        write_rows(*session_columns(summary.arms), path / f"sessions.{kind}", kind)
    frame: pd.DataFrame = pq.read_table(path / "sessions.parquet").to_pandas()
    assert len(pd.read_csv(path / "sessions.csv")) == len(frame)
    return frame


@pytest.mark.parametrize("summary", BATCHES, ids=("plain", "two sessions", "hostile", "empty"))
def test_a_row_per_joint_and_coefficient(
    summary: BatchSummary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drift_sessions, "ROWS_AT_ONCE", 100)
    frame = sessions_of(summary, tmp_path)
    assert len(frame) == sum(2 * len(session.joints) for session in summary.sessions)
    assert not frame.duplicated(["robot", "session", "joint", "coefficient"]).any()


def test_a_row_holds_the_session_s_numbers(tmp_path: Path) -> None:
    """Also of a path that no encoding knows, which is written with its bytes."""
    sessions = (replace(ARM.sessions[0], path="r\udcff.csv"), *ARM.sessions[1:])
    written = sessions_of(batch_by_hand.batch(replace(ARM, sessions=sessions)), tmp_path)
    assert written["path"][0] == "r\\udcff.csv"
    frame: Any = written.set_index(["session", "joint", "coefficient"])
    row, alone, still = (frame.loc[key] for key in ((13, 2, "coulomb_nm"), (9, 2, "coulomb_nm"), (1, 7, "coulomb_nm")))
    value = ARM.sessions[12].joints[1].coefficients["coulomb_nm"]
    assert (row["value"], row["ci95_low"]) == (value.value, value.low)
    assert (row["outside"], row["compared"], row["reference"], row["note"]) == (True, True, False, "after grease")
    assert (alone["compared"], alone["outside"]) == (False, None)
    assert np.isnan(alone["compared_value"])
    assert alone["left_out"].startswith("payload")
    assert np.isnan(still["value"])
    assert (still["unit"], "does not move" in still["reason"]) == ("N m", True)
