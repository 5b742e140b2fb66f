"""Estimate -> a tidy CSV table: one row per joint and cycle that counts."""

import csv
import io
import math
from dataclasses import fields
from typing import Any

import numpy as np

from friction_audit.errors import csv_text
from friction_audit.friction.history import Coefficient, CoefficientHistory, JointFriction
from friction_audit.io.tidy_table import Column, JointRows, TidyTable, as_column
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import REASONS
from friction_audit.reporting.units import column_in_unit, table_in_unit

COLUMNS = tuple(f.name for f in fields(CoefficientHistory))
HEADER = ("joint", "name", *COLUMNS)


def history_csv(estimate: Estimate) -> str:
    """Return the histories of all joints; an empty cell where a window cannot give a value."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(column_in_unit(name, estimate.log.source.torque_unit) for name in HEADER)
    for joint in estimate.friction.joints:
        writer.writerows(_rows(joint))
    return text.getvalue()


def _rows(joint: JointFriction) -> list[list[str]]:
    columns = [np.asarray(getattr(joint.history, name)).tolist() for name in COLUMNS]
    return [list(map(csv_cell, (joint.joint, joint.name, *row))) for row in zip(*columns, strict=True)]


def csv_cell(value: Any) -> str:  # noqa: ANN401 - any cell
    """Return a value as a cell; an empty one for None and NaN, 0 or 1 for a flag."""
    match value:
        case None:
            return ""
        case str():
            return csv_text(value)
        case float():
            return "" if math.isnan(value) else f"{value:.10g}"
    return str(int(value))


COEFFICIENTS: dict[str, type] = {
    "model": str,
    "method": str,
    "cycles": int,
    "left_out_cycles": int,
    "moving_s": float,
    "coulomb_nm": float,
    "coulomb_low_nm": float,
    "coulomb_high_nm": float,
    "viscous_nms_per_rad": float,
    "viscous_low_nms_per_rad": float,
    "viscous_high_nms_per_rad": float,
    "offset_nm": float,
    "gravity_error_nm": float,
    "condition_number": float,
    "correlation": float,
    "residual_rms_nm": float,
    "reason": str,
}
HISTORY: dict[str, type] = {f.name: int if f.name == "cycle" else float for f in fields(CoefficientHistory)}
CYCLES: dict[str, type] = {
    "cycle": int,
    "start_s": float,
    "stop_s": float,
    "peak_speed_rad_s": float,
    "net_energy_j": float,
    "compensation_j": float,
    "dissipated_j": float,
    "path_rad": float,
    "displacement_rad": float,
    "open": bool,
    "left_out": str,
}
INTERACTION: dict[str, type] = {"time_s": float, "q_rad": float, "dq_rad_s": float, "interaction_nm": float}
COMPENSATION: dict[str, type] = {"compensation_nm": float}

ESTIMATE_TABLES: tuple[str, ...] = ("coefficients", "coefficient_history", "cycles", "interaction")
"""Names of the tables of an estimate."""


def estimate_tables(estimate: Estimate) -> tuple[TidyTable, ...]:
    """Return the tables of an estimate, in the order of ESTIMATE_TABLES."""
    tables = (_coefficients(estimate), _history(estimate), _cycles(estimate), _interaction(estimate))
    return tuple(table_in_unit(table, estimate.log.source.torque_unit) for table in tables)


def _coefficients(estimate: Estimate) -> TidyTable:
    return TidyTable(
        name="coefficients",
        summary="friction coefficients of a joint over the whole log, with 95 % intervals",
        types=COEFFICIENTS,
        time=None,
        rows=tuple(
            JointRows(joint=one.joint, name=one.name, columns=_one_row(_coefficient_cells(one), COEFFICIENTS))
            for one in estimate.friction.joints
        ),
    )


def _one_row(cells: dict[str, Any], types: dict[str, type]) -> dict[str, Column]:
    return {name: as_column([cells[name]], kind) for name, kind in types.items()}


def _coefficient_cells(joint: JointFriction) -> dict[str, Any]:
    return {
        "model": joint.model,
        "method": joint.method,
        "cycles": joint.cycles,
        "left_out_cycles": joint.rejected_cycles,
        "moving_s": joint.moving_s,
        **interval_cells("coulomb{}_nm", joint.coulomb),
        **interval_cells("viscous{}_nms_per_rad", joint.viscous),
        "offset_nm": joint.offset_nm,
        "gravity_error_nm": joint.gravity_error_nm,
        "condition_number": joint.condition_number,
        "correlation": joint.correlation,
        "residual_rms_nm": None if joint.regression is None else joint.regression.residual_rms_nm,
        "reason": joint.reason,
    }


def interval_cells(name: str, coefficient: Coefficient) -> dict[str, float]:
    """Return value and ends of the interval by name; ``{}`` in the name is filled with ``_low`` and ``_high``."""
    ends = {"": coefficient.value, "_low": coefficient.low, "_high": coefficient.high}
    return {name.format(end): value for end, value in ends.items()}


def _history(estimate: Estimate) -> TidyTable:
    return TidyTable(
        name="coefficient_history",
        summary="friction coefficients of a joint after a cycle that counts, from the last cycles, with 95 % intervals",
        types=HISTORY,
        time="stop_s",
        rows=tuple(
            JointRows(
                joint=one.joint,
                name=one.name,
                columns={name: np.asarray(getattr(one.history, name)) for name in HISTORY},
            )
            for one in estimate.friction.joints
        ),
    )


def _cycles(estimate: Estimate) -> TidyTable:
    seen = estimate.interaction
    return TidyTable(
        name="cycles",
        summary="an energy cycle of a joint, from rest to rest, also one that is left out of the estimate",
        types=CYCLES,
        time="stop_s",
        rows=tuple(
            JointRows(joint=number, name=name, columns=_cycle_columns(estimate, column))
            for column, (number, name) in enumerate(zip(seen.joint_numbers, seen.joint_names, strict=True))
        ),
    )


def _cycle_columns(estimate: Estimate, column: int) -> dict[str, Column]:
    own = estimate.cycles.of_joint(column)
    return {
        "cycle": np.arange(1, len(own.joint) + 1),
        "start_s": own.start_s,
        "stop_s": own.stop_s,
        "peak_speed_rad_s": own.peak_speed_rad_s,
        "net_energy_j": own.sums.work_j,
        "compensation_j": own.sums.compensation_j,
        "dissipated_j": own.sums.dissipated_j,
        "path_rad": own.sums.path_rad,
        "displacement_rad": own.sums.displacement_rad,
        "open": own.open,
        "left_out": [REASONS[reason] for reason in own.reason],
    }


def _interaction(estimate: Estimate) -> TidyTable:
    seen = estimate.interaction
    compensated = {} if seen.compensation is None else COMPENSATION
    return TidyTable(
        name="interaction",
        summary="motion of a joint and torque at its friction port at a sample of the log",
        types=INTERACTION | compensated,
        time="time_s",
        rows=tuple(
            JointRows(joint=number, name=name, columns=_interaction_columns(estimate, column))
            for column, (number, name) in enumerate(zip(seen.joint_numbers, seen.joint_names, strict=True))
        ),
    )


def _interaction_columns(estimate: Estimate, column: int) -> dict[str, Column]:
    seen = estimate.interaction
    found: dict[str, Column] = {
        "time_s": seen.t,
        "q_rad": seen.q[:, column],
        "dq_rad_s": seen.dq[:, column],
        "interaction_nm": seen.torque[:, column],
    }
    if seen.compensation is not None:
        found["compensation_nm"] = seen.compensation[:, column]
    return found
