"""Tables of a result -> files in a folder: topics of an MCAP, CSV, Parquet."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.cli.console import Voice
from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from friction_audit.io.tidy_table import TidyTable
    from friction_audit.joint_log import JointLog

MCAP = "mcap"


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportPlan:
    """What is written where.

    Attributes:
        folder: Where.
        name: What the MCAP is called, without its ending.
        prefix: What the names of the tables' files begin with.
        kinds: Which of mcap, csv and parquet.
    """

    folder: Path
    name: str
    prefix: str = ""
    kinds: Sequence[str]

    def mcap(self) -> Path:
        """Return the file of the topics."""
        return self.folder / f"{self.name}.{MCAP}"

    def table(self, name: str, kind: str) -> Path:
        """Return the file of a table."""
        return self.folder / f"{self.prefix}{name}.{kind}"

    def files(self, tables: Sequence[str]) -> list[Path]:
        """Return the files that tables of these names are written to."""
        topics = [self.mcap()] if MCAP in self.kinds else []
        return topics + [self.table(name, kind) for kind in self.kinds if kind != MCAP for name in tables]


def plan_exports(folder: Path | None, kinds: Sequence[str], name: str) -> ExportPlan | None:
    """Return what is to be written beside a result, or None where nothing was asked for.

    Raises:
        UsageError: If there is no folder to write to.
    """
    if not kinds:
        return None
    if folder is None:
        raise UsageError(f"--export {','.join(kinds)}: no folder to write to; name one with --output DIR")
    return ExportPlan(folder=folder, name=name, kinds=kinds)


def write_exports(
    plan: ExportPlan,
    tables: "Sequence[TidyTable]",
    log: "JointLog",
    voice: Voice,
    *,
    overwrite: bool,
) -> list[Path]:
    """Write the tables, each file whole or not at all; return the files.

    Args:
        plan: What is written where.
        tables: The tables.
        log: The log that they were made from.
        voice: Told what is written.
        overwrite: If True, files that exist are replaced.
    """
    from friction_audit.io.files import whole_file
    from friction_audit.io.writers.tables import write_table
    from friction_audit.io.writers.topics import span_of, write_topics

    for kind in plan.kinds:
        with voice.step(f"export {kind}"):
            if kind == MCAP:
                span = span_of(log)
                with whole_file(plan.mcap(), overwrite=overwrite) as draft:
                    write_topics(tables, span, draft)
                continue
            for table in tables:
                with whole_file(plan.table(table.name, kind), overwrite=overwrite) as draft:
                    write_table(table, draft, kind)
    return plan.files([table.name for table in tables])
