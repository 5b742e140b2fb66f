"""A file -> JointLog: one reader per container format, one table of foreign names, every recording vetted."""

from friction_audit.io.readers.read import READERS, arm_told_by, list_topics, read_log
from friction_audit.io.readers.reader import ReadOptions, SeveralArmsError

__all__ = ["READERS", "ReadOptions", "SeveralArmsError", "arm_told_by", "list_topics", "read_log"]
