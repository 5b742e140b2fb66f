"""LogReplay -> a tidy CSV table: one row per joint and cycle of its compensator."""

import csv
import io
from dataclasses import asdict
from typing import Any

import numpy as np

from friction_audit.compensation.compensators import kind_of
from friction_audit.compensation.result import STATUSES, JointReplay, ReplayHistory, Signals
from friction_audit.io.tidy_table import Column, JointRows, TidyTable, as_column
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.json.replay import HISTORY, NUMBERS
from friction_audit.reporting.tables.of_estimate import csv_cell
from friction_audit.reporting.units import column_in_unit, table_in_unit

HEADER = ("joint", "name", "cycle", *HISTORY, "acted", "status")


def replay_csv(found: LogReplay) -> str:
    """Return the histories of all joints; an empty cell where there is no estimate yet."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(column_in_unit(name, found.estimate.log.source.torque_unit) for name in HEADER)
    for joint in found.replay.joints:
        writer.writerows(_rows(joint))
    return text.getvalue()


def _rows(joint: JointReplay) -> list[list[str]]:
    history = joint.history
    if history is None:
        return []
    columns = zip(*(getattr(history, name).tolist() for name in HISTORY), strict=True)
    found = zip(columns, history.acted.tolist(), history.status.tolist(), strict=True)
    return [
        list(map(csv_cell, (joint.joint, joint.name, cycle, *values, acted, STATUSES[status])))
        for cycle, (values, acted, status) in enumerate(found, start=1)
    ]


PASSIVITY: dict[str, type] = {
    "violations": int,
    "lowest_j": float,
    "injected_j": float,
    "unserved_j": float,
    "active_fraction": float,
}
"""Fields of ``Passivity`` that the table shows."""
JOINTS: dict[str, type] = {
    "compensator": str,
    **{name: int if name == "cycles_to_converge" else float for name in NUMBERS},
    **PASSIVITY,
    "reason": str,
}
CYCLES: dict[str, type] = {"cycle": int, **dict.fromkeys(HISTORY, float), "acted": bool, "status": str}
SIGNALS: dict[str, type] = {
    "time_s": float,
    "dq_without_rad_s": float,
    "dq_with_rad_s": float,
    "interaction_without_nm": float,
    "interaction_with_nm": float,
    "compensation_nm": float,
    "passivity_nm": float,
}

REPLAY_TABLES: tuple[str, ...] = ("replay_joints", "replay_cycles", "replay_signals")
"""Names of the tables of a replay."""


def replay_tables(found: LogReplay) -> tuple[TidyTable, ...]:
    """Return the tables of a replay, in the order of REPLAY_TABLES."""
    joints = found.replay.joints
    tables = (
        TidyTable(
            name="replay_joints",
            summary="what a compensator would have come to on a joint, over the whole log",
            types=JOINTS,
            time=None,
            rows=tuple(_rows_of_replay(one, _joint_columns(one)) for one in joints),
        ),
        TidyTable(
            name="replay_cycles",
            summary="a cycle of the compensator on a joint: energy, coefficients applied and estimated",
            types=CYCLES,
            time="stop_s",
            rows=tuple(_rows_of_replay(one, _cycle_columns(one.history)) for one in joints if one.history is not None),
        ),
        TidyTable(
            name="replay_signals",
            summary="motion and torque of a joint without the compensator and with it at a sample of the log",
            types=SIGNALS,
            time="time_s",
            rows=tuple(
                _rows_of_replay(one, _signals(one.without, one.replayed)) for one in joints if one.replayed is not None
            ),
        ),
    )
    return tuple(table_in_unit(table, found.estimate.log.source.torque_unit) for table in tables)


def _rows_of_replay(joint: JointReplay, columns: dict[str, Column]) -> JointRows:
    return JointRows(joint=joint.joint, name=joint.name, columns=columns)


def _joint_columns(joint: JointReplay) -> dict[str, Column]:
    cells: dict[str, Any] = dict.fromkeys(JOINTS)
    cells |= {} if joint.numbers is None else asdict(joint.numbers)
    cells |= {} if joint.passivity is None else asdict(joint.passivity)
    cells |= {"compensator": kind_of(joint.compensator).name, "reason": joint.reason}
    return {name: as_column([cells[name]], kind) for name, kind in JOINTS.items()}


def _cycle_columns(history: ReplayHistory) -> dict[str, Column]:
    return {
        "cycle": np.arange(1, len(history.status) + 1),
        **{name: getattr(history, name) for name in HISTORY},
        "acted": history.acted,
        "status": [STATUSES[status] for status in history.status],
    }


def _signals(without: Signals, replayed: Signals) -> dict[str, Column]:
    """Return what both have, up to where the compensated joint ran away, if it did."""
    end = min(len(without.t), len(replayed.t))
    return {
        "time_s": without.t[:end],
        "dq_without_rad_s": without.dq[:end],
        "dq_with_rad_s": replayed.dq[:end],
        "interaction_without_nm": without.interaction_nm[:end],
        "interaction_with_nm": replayed.interaction_nm[:end],
        "compensation_nm": replayed.compensation_nm[:end],
        "passivity_nm": replayed.passivity_nm[:end],
    }
