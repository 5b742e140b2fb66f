"""A file -> JointLog: one reader per container format, one table of foreign names, every recording vetted."""

from friction_audit.ingest.read import list_topics, read_log
from friction_audit.ingest.reader import ReadOptions
from friction_audit.ingest.readers import READERS

__all__ = ["READERS", "ReadOptions", "list_topics", "read_log"]
