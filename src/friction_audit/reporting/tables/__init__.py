"""Any result -> tidy tables, the same for files, topics and frames."""

from friction_audit.reporting.tables.of_diagnosis import DIAGNOSE_TABLES, diagnose_tables
from friction_audit.reporting.tables.of_estimate import ESTIMATE_TABLES, estimate_tables
from friction_audit.reporting.tables.of_replay import REPLAY_TABLES, replay_tables
from friction_audit.reporting.tables.of_report import REPORT_TABLES, report_tables

__all__ = [
    "DIAGNOSE_TABLES",
    "ESTIMATE_TABLES",
    "REPLAY_TABLES",
    "REPORT_TABLES",
    "diagnose_tables",
    "estimate_tables",
    "replay_tables",
    "report_tables",
]
