"""JointLog -> file; tables of results -> files."""

from friction_audit.export.write_log import choose_writer, write_log
from friction_audit.export.writer import Writer
from friction_audit.export.writers import WRITERS

__all__ = ["WRITERS", "Writer", "choose_writer", "write_log"]
