"""LogReport -> the tidy tables of all its parts."""

from friction_audit.io.tidy_table import TidyTable
from friction_audit.reporting.log_report import LogReport
from friction_audit.reporting.tables.of_diagnosis import DIAGNOSE_TABLES, diagnose_tables
from friction_audit.reporting.tables.of_estimate import ESTIMATE_TABLES, estimate_tables
from friction_audit.reporting.tables.of_replay import REPLAY_TABLES, replay_tables

REPORT_TABLES = (*ESTIMATE_TABLES, *REPLAY_TABLES, *DIAGNOSE_TABLES)
"""Names of the tables of a report; those of a part without an answer are not there."""


def report_tables(report: LogReport) -> tuple[TidyTable, ...]:
    """Return the tables of a report, in the order of REPORT_TABLES."""
    replayed = () if report.replay is None else replay_tables(report.replay)
    missing = () if report.diagnosis is None else diagnose_tables(report.diagnosis)
    return (*estimate_tables(report.estimate), *replayed, *missing)
