"""A file -> JointLog: one reader per container format, one table of foreign names, every recording vetted."""

from friction_audit.ingest.read import list_topics, read_log
from friction_audit.ingest.reader import ReadOptions, SeveralArmsError
from friction_audit.ingest.readers import READERS
from friction_audit.ingest.told_arm import arm_told_by

__all__ = ["READERS", "ReadOptions", "SeveralArmsError", "arm_told_by", "list_topics", "read_log"]
