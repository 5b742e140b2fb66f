"""Tables of results: what is in them, by hand and against the results themselves."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from friction_audit.reporting.log_report import LogReport

from friction_audit.cli import choices
from friction_audit.io.tidy_table import TidyTable
from friction_audit.reporting import tables
from friction_audit.reporting.tables import diagnose_tables, report_tables
from tests.reporting import log_report_by_hand as by_hand
from tests.reporting.diagnosis_by_hand import AMBIGUOUS

UNITLESS = {
    "joint", "name", "model", "cycles", "left_out_cycles", "condition_number", "correlation", "reason", "cycle",
    "open", "left_out", "compensator", "dissipation_removed", "dissipation_removed_updated", "limited_fraction",
    "cycles_to_converge", "violations", "active_fraction", "acted", "status", "verdict", "message", "shrink",
    "held_out_cycles", "omnibus_p_value", "remaining_p_value", "rank", "effect", "label", "alternatives", "p_value",
    "where", "decide", "parameter", "value", "ci95_low", "ci95_high", "step", "of", "axis", "axis_label", "centre",
    "held_out", "method",
}  # fmt: skip
"""Columns of words, counts, flags and shares; of an effect's numbers the name of the number tells the unit."""
UNIT = re.compile(r"_(s|rad|rad_s|nm|nm_s|nms_per_rad|j)$")


@cache
def report() -> LogReport:
    return by_hand.report()


@cache
def every() -> dict[str, TidyTable]:
    return {table.name: table for table in report_tables(report())}


@pytest.mark.parametrize("name", tables.REPORT_TABLES)
def test_columns_are_complete_and_of_their_kind(name: str) -> None:
    table = every()[name]
    for rows in table.rows:
        assert list(rows.columns) == list(table.types)
        assert len({len(column) for column in rows.columns.values()}) == 1
        for column, kind in table.types.items():
            found = {type(value) for value in np.asarray(rows.columns[column], dtype=object)}
            assert found <= {kind, float, np.float64, type(None)} if kind is int else found <= {kind}, column


@pytest.mark.parametrize("name", tables.REPORT_TABLES)
def test_columns_tell_their_units(name: str) -> None:
    assert [column for column in every()[name].types if not (UNIT.search(column) or column in UNITLESS)] == []


def test_names_are_those_of_the_options() -> None:
    assert tuple(every()) == tables.REPORT_TABLES == choices.REPORT_TABLES
    assert choices.ESTIMATE_TABLES == tables.ESTIMATE_TABLES
    assert choices.REPLAY_TABLES == tables.REPLAY_TABLES
    assert choices.DIAGNOSE_TABLES == tables.DIAGNOSE_TABLES


def test_coefficients_are_the_estimate_s() -> None:
    found = every()["coefficients"].rows
    for rows, joint in zip(found, report().estimate.friction.joints, strict=True):
        assert (rows.joint, rows.name) == (joint.joint, joint.name)
        assert rows.columns["coulomb_nm"][0] == pytest.approx(joint.coulomb.value, nan_ok=True)
        assert rows.columns["viscous_high_nms_per_rad"][0] == pytest.approx(joint.viscous.high, nan_ok=True)
        assert rows.columns["reason"][0] == joint.reason


def test_cycles_hold_all_energy() -> None:
    cycles = report().estimate.cycles
    for column, rows in enumerate(every()["cycles"].rows):
        own = cycles.of_joint(column)
        assert np.sum(rows.columns["net_energy_j"]) == pytest.approx(own.work_j.sum())
        assert list(rows.columns["cycle"]) == list(range(1, len(own.joint) + 1))


def test_residual_is_measured_less_model() -> None:
    """Half a newton metre, of which the declared model has 0.4 and the grown one 0.48."""
    found = report().diagnosis
    assert found is not None
    joint = next(one for one in found.discrepancy.joints if one.traces is not None)
    assert joint.traces is not None
    whole = np.ones_like(joint.traces.measured)
    told = replace(joint, traces=replace(joint.traces, measured=0.5 * whole, before=0.4 * whole, after=0.48 * whole))
    made = diagnose_tables(replace(found, discrepancy=replace(found.discrepancy, joints=(told,))))
    (rows,) = next(table for table in made if table.name == "residual").rows
    assert rows.columns["declared_nm"] == pytest.approx(0.4)
    assert rows.columns["grown_nm"] == pytest.approx(0.48)
    assert rows.columns["residual_before_nm"] == pytest.approx(0.1)
    assert rows.columns["residual_after_nm"] == pytest.approx(0.02)


def test_two_that_are_an_alternative_only_together_are_one_word() -> None:
    found = report().diagnosis
    assert found is not None
    (effect,) = AMBIGUOUS.effects
    pair = ("torque_drift", "inertia_error")
    told = replace(effect, alternatives=("asymmetric_coulomb", *pair), together=(pair,))
    joints = (replace(AMBIGUOUS, effects=(told,)),)
    made = diagnose_tables(replace(found, discrepancy=replace(found.discrepancy, joints=joints)))
    (rows,) = next(table for table in made if table.name == "effects").rows
    assert list(rows.columns["alternatives"]) == ["asymmetric_coulomb torque_drift+inertia_error"]


def test_a_part_without_an_answer_has_no_tables() -> None:
    alone = LogReport(estimate=report().estimate)
    assert tuple(table.name for table in report_tables(alone)) == tables.ESTIMATE_TABLES
