from friction_audit.api.calls import diagnose_log as diagnose_log
from friction_audit.api.calls import estimate_log as estimate_log
from friction_audit.api.calls import read_log as read_log
from friction_audit.api.calls import replay_log as replay_log
from friction_audit.api.calls import report_log as report_log
from friction_audit.api.calls import simulate_log as simulate_log
from friction_audit.api.calls import write_log as write_log
from friction_audit.api.frames import to_frames as to_frames
from friction_audit.errors import FrictionAuditError as FrictionAuditError

__version__: str
__all__ = [
    "FrictionAuditError",
    "diagnose_log",
    "estimate_log",
    "read_log",
    "replay_log",
    "report_log",
    "simulate_log",
    "to_frames",
    "write_log",
]
