"""Any result -> pandas."""

from typing import TYPE_CHECKING

from friction_audit.audit import Diagnosis, Estimate, LogReplay
from friction_audit.errors import UsageError
from friction_audit.export.write_tables import to_frame
from friction_audit.report.log_report import LogReport
from friction_audit.report.tables import diagnose_tables, estimate_tables, replay_tables, report_tables
from friction_audit.tidy_table import TidyTable

if TYPE_CHECKING:
    import pandas as pd


def to_frames(result: Estimate | LogReplay | Diagnosis | LogReport) -> "dict[str, pd.DataFrame]":
    """Return the tables of a result by name, with units in the names of their columns.

    They are those that ``--export csv`` and ``--export parquet`` write: of an estimate ``coefficients``,
    ``coefficient_history``, ``cycles`` and ``interaction``; of a replay ``replay_joints``, ``replay_cycles`` and
    ``replay_signals``; of a diagnosis ``verdicts``, ``effects``, ``effect_parameters``, ``gap_ladder``,
    ``residual_profiles``, ``residual`` and ``simulated_motion``; of a report all of them.

    Args:
        result: What ``estimate_log``, ``replay_log``, ``diagnose_log`` or ``report_log`` returned.

    Raises:
        UsageError: If it is none of these.
    """
    return {table.name: to_frame(table) for table in _tables(result)}


def _tables(result: Estimate | LogReplay | Diagnosis | LogReport) -> tuple[TidyTable, ...]:
    match result:
        case Estimate():
            return estimate_tables(result)
        case LogReplay():
            return replay_tables(result)
        case Diagnosis():
            return diagnose_tables(result)
        case LogReport():
            return report_tables(result)
        case _:
            raise UsageError(
                f"to_frames: {type(result).__name__}: expected the result of estimate_log, replay_log, diagnose_log or "
                "report_log; call one of them first"
            )
