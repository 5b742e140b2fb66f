"""JointLog -> file; tables of results -> files."""

from friction_audit.io.writers.write_log import WRITERS, choose_writer, write_log
from friction_audit.io.writers.writer import Writer

__all__ = ["WRITERS", "Writer", "choose_writer", "write_log"]
