"""A file -> JointLog: one reader per container format, one table of foreign names; every recording is checked."""

from friction_audit.io.readers.channel_names import arm_of_log
from friction_audit.io.readers.read import READERS, list_topics, log_from_frame, read_log
from friction_audit.io.readers.reader import ReadOptions, SeveralLogsError

__all__ = ["READERS", "ReadOptions", "SeveralLogsError", "arm_of_log", "list_topics", "log_from_frame", "read_log"]
