"""What a command makes of a result: documents, figures and tables in a folder, and text on standard output."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, NamedTuple

from friction_audit.cli.chain import check_outputs
from friction_audit.cli.console import Voice, remark, say
from friction_audit.errors import UsageError
from friction_audit.reporting.figures import FIGURES, FigureKind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from friction_audit.io.writers.tables import TidyTable
    from friction_audit.joint_log import JointLog

MCAP = "mcap"
Figures = Sequence[tuple[str, int | None, str]]  # kind, joint (None: all of them) and name of each


class ResultFolder(NamedTuple):
    """The folder of a result, or none, and what is written there, each file whole or not at all."""

    folder: Path | None  # where; without one nothing is written
    name: str = ""  # of the MCAP with the tables as topics
    figures: Sequence[str] = ()  # names of the figures
    formats: Sequence[str] = ()  # of the figures
    exports: Sequence[str] = ()  # formats that the tables are written in: mcap, csv, parquet
    prefix: str = ""  # of the names of the tables' files
    overwrite: bool = False  # whether files that exist are replaced

    def check(self, log: Path | None = None, files: Sequence[str] = (), *results: str) -> None:
        """Refuse what could not be written, before anything long is done: files by name, figures, tables.

        ``results``: where the results are specified whose tables may be written, ``module:DOCUMENT``.
        """
        if self.folder is None:
            if self.exports:
                asked = ",".join(self.exports)
                raise UsageError(f"--export {asked}: no folder to write to; name one with --output DIR")
            return
        # Whichever joints there are, known before reading.
        figures = [self.folder / f"{kind}.{suffix}" for kind in self.figures for suffix in self.formats]
        single = (f"{kind}-joint[0-9]*.{suffix}" for kind in self.figures for suffix in self.formats)
        figures += sorted(path for pattern in single for path in self.folder.glob(pattern))
        specified = [resolve_name(f"friction_audit.reporting.{result}") for result in results if self.exports]
        tables = [table.name for document in specified for table, _ in document.files]
        paths = [*(self.folder / file for file in files), *figures, *self.exported(tables)]
        check_outputs(paths, overwrite=self.overwrite, log=log)

    @property
    def stages(self) -> int:
        """Steps that writing takes."""
        return (len(self.figures) if self.folder else 0) + len(self.exports)

    def exported(self, tables: Sequence[str]) -> list[Path]:
        """Return the files that tables of these names are written to."""
        folder = self.folder or Path()
        topics = [folder / f"{self.name}.{MCAP}"] if MCAP in self.exports else []
        kinds = [kind for kind in self.exports if kind != MCAP]
        return topics + [folder / f"{self.prefix}{table}.{kind}" for kind in kinds for table in tables]

    def write(self, name: str, content: Callable[[Path], object] | bytes) -> None:
        """Write one file of the folder."""
        from friction_audit.io.files import whole_file

        if self.folder is not None:
            with whole_file(self.folder / name, overwrite=self.overwrite) as draft:
                draft.write_bytes(content) if isinstance(content, bytes) else content(draft)

    def write_document(self, name: str, document: Callable[[], Mapping[str, Any]], voice: Voice) -> str:
        """Write a document; return its text for who asks for it: that of a day has 200 000 cycles."""
        from friction_audit.reporting.documents import write_document

        text = write_document(document()) if voice.json or self.folder else ""
        self.write(name, text.encode())
        return text

    def write_csv(self, name: str, table: "TidyTable") -> None:
        """Write a table as CSV, unless it is one of those that are exported as such."""
        from friction_audit.io.writers.tables import write_table

        if "csv" not in self.exports or name != f"{self.prefix}{table.name}.csv":
            self.write(name, partial(write_table, table, kind="csv"))

    def save_figure(self, name: str, figure: "Figure") -> list[Path]:
        """Write a figure in all formats; return its files."""
        from friction_audit.reporting.figures.style import figure_bytes

        for suffix in self.formats:
            self.write(f"{name}.{suffix}", figure_bytes(figure, suffix))
        return [(self.folder or Path()) / f"{name}.{suffix}" for suffix in self.formats]

    def write_figures(
        self, results: Mapping[str, object], joints: Sequence[int], unit: str, voice: Voice, *, each_joint: bool = False
    ) -> Figures:
        """Draw figures of results, all joints on a sheet and, if asked for, each joint alone; return their files."""
        if self.folder is None:
            return []
        from friction_audit.parallel import in_processes, workers_for
        from friction_audit.reporting.figures.panels import label_in_unit
        from friction_audit.reporting.figures.style import figure_bytes, load_matplotlib

        # A sheet of one joint is that joint's figure.
        sheet = joints[0] if len(joints) == 1 else None
        alone = joints if each_joint and sheet is None else ()
        kinds = [kind for kind in FIGURES if kind.result in results and kind.name in self.figures]
        load_matplotlib(self.formats)  # once, and not by every copy
        tasks: list[tuple[FigureKind, int | None]] = []
        for kind in kinds:
            layout, result = kind.layout(), results[kind.result]
            shown = {one.joint for one in layout.joints(result) if layout.has(result, one)}
            empty = [one for one in alone if one not in shown]
            tasks += [(kind, sheet), *((kind, one) for one in alone if one in shown)]
            if empty and not voice.quiet:
                from friction_audit.reporting.words import joints_label

                remark(f"{kind.name}: no figure of {joints_label(empty)} alone: {layout.lacks}")

        def draw(k: int) -> list[bytes]:
            kind, joint = tasks[k]
            figure = label_in_unit(kind.draw(results[kind.result], joint), unit)
            return [figure_bytes(figure, suffix) for suffix in self.formats]

        contents = in_processes(draw, len(tasks), workers_for(len(tasks)))
        files = []
        for kind, joint in tasks:
            name = f"{kind.name}-joint{joint}" if joint in alone else kind.name
            with voice.step(f"draw {name}"):
                for suffix, content in zip(self.formats, next(contents), strict=True):
                    self.write(f"{name}.{suffix}", content)
                    files.append((kind.name, joint, f"{self.folder / name}.{suffix}"))
        return files

    def write_exports(self, tables: "Sequence[TidyTable]", log: "JointLog", voice: Voice) -> list[Path]:
        """Write the tables in the formats that were asked for; return their files."""
        if not self.exports:
            return []
        from friction_audit.io.writers.mcap import write_topics
        from friction_audit.io.writers.tables import write_table

        for kind in self.exports:
            with voice.step(f"export {kind}"):
                if kind == MCAP:
                    self.write(f"{self.name}.{MCAP}", lambda draft: write_topics(tables, log, draft))
                    continue
                for table in tables:
                    self.write(f"{self.prefix}{table.name}.{kind}", partial(write_table, table, kind=kind))
        return self.exported([table.name for table in tables])


def check_junit(path: Path | None, limits: Sequence[object], *, overwrite: bool) -> None:
    """Refuse a file of limits that could not be written or may be a log, or for which there are no limits."""
    if path is None:
        return
    if path.suffix.lower() != ".xml":
        raise UsageError(f"--junit {path}: ending {path.suffix or 'missing'}: expected .xml; rename it")
    if not limits:
        raise UsageError(f"--junit {path}: there is no limit to write; give one with --fail-on, e.g. coulomb=15%")
    check_outputs([path], overwrite=overwrite)


def write_junit(path: Path | None, text: str, *, overwrite: bool) -> None:
    """Write the limits, if they are to be written."""
    from friction_audit.io.files import whole_file

    if path is not None:
        with whole_file(path, overwrite=overwrite) as draft:
            draft.write_text(text, encoding="utf-8")


def show(document: str | Callable[[], Mapping[str, Any]], lines: Callable[[], Iterable[str]], voice: Voice) -> None:
    """Print the document, or the table for people."""
    if not voice.json:
        say("\n".join(lines()))
        return
    from friction_audit.reporting.documents import write_document

    say(document if isinstance(document, str) else write_document(document()), nl=False)
