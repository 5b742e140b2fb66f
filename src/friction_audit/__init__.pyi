from friction_audit.api import (
    diagnose_log as diagnose_log,
    estimate_log as estimate_log,
    log_from_frame as log_from_frame,
    plot as plot,
    read_log as read_log,
    replay_log as replay_log,
    report_log as report_log,
    simulate_log as simulate_log,
    to_frames as to_frames,
    write_log as write_log,
)
from friction_audit.errors import FrictionAuditError as FrictionAuditError

__version__: str
__all__ = [
    "FrictionAuditError",
    "diagnose_log",
    "estimate_log",
    "log_from_frame",
    "plot",
    "read_log",
    "replay_log",
    "report_log",
    "simulate_log",
    "to_frames",
    "write_log",
]
