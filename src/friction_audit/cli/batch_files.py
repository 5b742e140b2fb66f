"""BatchSummary -> files in the folder of its ledger."""

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.cli import choices
from friction_audit.cli.console import DAMAGED, EXCEEDED, Voice
from friction_audit.errors import AnalysisError, UsageError

if TYPE_CHECKING:
    from friction_audit.batch.executor import Executor
    from friction_audit.batch.ledger import Ledger
    from friction_audit.batch.manifest import BatchSettings
    from friction_audit.batch.run_batch import Standing
    from friction_audit.drift.report import ArmDrift
    from friction_audit.reporting.drift import BatchSummary
    from friction_audit.reporting.html.page import Figure

DOCUMENT, PAGE, CSV, PARQUET = "batch.json", "batch.html", "sessions.csv", "sessions.parquet"
RESULTS = (DOCUMENT, PAGE, CSV, PARQUET)  # in the folder of the ledger, made anew whenever something is new
_COUNTS = re.compile(r"\d+ computed, \d+ known")
_COUNT = re.compile(r' {2}"(computed|known)": \d+,\n')
# Notes of the ledger: which settings made the results in its folder, and what they are.
SETTINGS, REPORTED = "reported_settings", "reported"
MOST_NAMED = 4  # files that a message names; more are counted
LONGEST_PREFIX = 60  # characters of an arm's name in the names of its files, which may have 255 bytes
UNTESTABLE = 7  # exit code: the sessions cannot test a limit that the user set


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchAnswer:
    """What a batch answers beyond its JSON document; a note of the ledger holds it."""

    text: str  # table and sentences
    warnings: Sequence[str]
    code: int  # exit code
    junit: str  # the limits as JUnit; empty without one
    codes: Mapping[str, Sequence[str]]  # of the warnings of each session that has some, by its path

    def text_of(self, standing: "Standing") -> str:
        """Return the text, with what was computed and known in this run."""
        return _COUNTS.sub(f"{standing.new} computed, {standing.known} known", self.text, count=1)


def document_lines(folder: Path, standing: "Standing") -> Iterator[str]:
    """Yield the lines of the document, with what was computed and known in this run."""
    counts = {"computed": standing.new, "known": standing.known}
    with (folder / DOCUMENT).open(encoding="utf-8") as lines:
        for line in lines:
            count = _COUNT.fullmatch(line)
            yield line if count is None else f'  "{count[1]}": {counts[count[1]]},\n'


def check_results(folder: Path, formats: Sequence[str], ledger: "Ledger", settings: "BatchSettings") -> None:
    """Refuse to replace results that this ledger and these settings did not make."""
    if ledger.note(SETTINGS) == settings.key():
        return
    figures = [found for kind in choices.BATCH_FIGURES for one in formats for found in folder.glob(f"*{kind}.{one}")]
    existing = [str(path) for path in (*(folder / name for name in RESULTS), *sorted(figures)) if path.exists()]
    if existing:
        more = f" and {len(existing) - MOST_NAMED} more" if len(existing) > MOST_NAMED else ""
        raise UsageError(
            f"{', '.join(existing[:MOST_NAMED])}{more}: made with other settings; nothing was computed; use "
            "--overwrite to replace them (the ledger keeps the numbers of both), or another folder with -o"
        )


def recall_results(request: object, folder: Path, ledger: "Ledger", voice: Voice) -> BatchAnswer | None:
    """Return the answer to the same request if all that was written with it is still there, else None."""
    written = ledger.note(REPORTED)
    if written is None:
        return None
    digest, _, text = written.partition(" ")
    if digest != _digest(text):
        voice.warn(
            [f"{ledger.path}: the note on the last report is damaged; the report is made again from the sessions"]
        )
        return None
    note = json.loads(text)
    files = note.pop("files")
    if note.pop("request") != _digest(request) or files != _stamps(folder, files):
        return None
    return BatchAnswer(**note)


def write_results(
    summary: "BatchSummary",
    junit: str,
    request: object,
    folder: Path,
    formats: list[str],
    ledger: "Ledger",
    settings: "BatchSettings",
    executor: "Executor",
    voice: Voice,
) -> BatchAnswer:
    """Write the document, the tables, the page and the figures, each whole or not at all; return the answer."""
    from friction_audit.io.files import whole_file
    from friction_audit.reporting.drift_text import batch_lines
    from friction_audit.reporting.html.batch_page import write_page

    ledger.write_note(SETTINGS, settings.key())  # before anything of it is replaced
    with ThreadPoolExecutor(max_workers=1, thread_name_prefix="tables") as pool, voice.step("draw the figures"):
        tables = pool.submit(_write_tables, summary, folder)  # while others draw
        drawn, pictures = _draw(summary, folder, formats, executor)
        tables.result()
    with voice.step(f"write {PAGE}"), whole_file(folder / PAGE, overwrite=True) as draft:
        draft.write_text(write_page(summary, pictures), encoding="utf-8")
    code = DAMAGED if summary.failed or any(session.damaged for session in summary.sessions) else 0
    if summary.exceeded or summary.cannot_tell:  # what was asked, the limits, comes before files that failed
        code = EXCEEDED if summary.exceeded else UNTESTABLE
    answer = BatchAnswer(
        text="".join(f"{line}\n" for line in batch_lines(summary, verbose=voice.verbose)),
        warnings=summary.warnings,
        code=code,
        junit=junit,
        codes={session.path: session.codes for session in summary.sessions if session.codes},
    )
    made = {"request": _digest(request), "files": _stamps(folder, [*RESULTS, *drawn])}
    written = json.dumps(made | asdict(answer))
    ledger.write_note(REPORTED, f"{_digest(written)} {written}")
    return answer


def _write_tables(summary: "BatchSummary", folder: Path) -> None:
    from friction_audit.io.files import whole_file
    from friction_audit.io.writers.tables import write_rows
    from friction_audit.reporting.drift import write_batch_document
    from friction_audit.reporting.drift_sessions import session_columns

    with whole_file(folder / DOCUMENT, overwrite=True) as draft, draft.open("w", encoding="utf-8") as file:
        file.writelines(write_batch_document(summary))
    for name, kind in ((CSV, "csv"), (PARQUET, "parquet")):
        with whole_file(folder / name, overwrite=True) as draft:
            write_rows(*session_columns(summary.arms), draft, kind)


def _digest(request: object) -> str:
    return hashlib.sha256(repr(request).encode()).hexdigest()


def _stamps(folder: Path, names: Iterable[str]) -> dict[str, list[int]]:
    """Return size and time of the last change of files, by name; of those that are there."""
    states = {name: (folder / name).stat() for name in names if (folder / name).exists()}
    return {name: [state.st_size, state.st_mtime_ns] for name, state in states.items()}


def _draw(
    summary: "BatchSummary", folder: Path, formats: list[str], executor: "Executor"
) -> "tuple[list[str], dict[str, Figure]]":
    """Draw the figures side by side and write their files; return the names of those, and what is for the page."""
    from friction_audit.batch.executor import Lost
    from friction_audit.io.files import whole_file
    from friction_audit.reporting.html.batch_page import draw, drawings_of

    names, pictures = [], {}
    for drawing, drawn in executor.run(draw, drawings_of(summary.arms, _prefixes(summary.arms), formats)):
        if isinstance(drawn, Lost):
            raise AnalysisError(f"{drawing.name or drawing.anchor}: cannot be drawn: {drawn.message}")
        files, figure = drawn
        for name, content in files.items():
            with whole_file(folder / name, overwrite=True) as draft:
                draft.write_bytes(content)
            names.append(name)
        if figure is not None:
            pictures[drawing.anchor] = figure
    return sorted(names), pictures


def _prefixes(arms: "Sequence[ArmDrift]") -> dict[str, str]:
    """Return what the files of each arm that is drawn begin with: nothing for the only one, else its name."""
    robots = [arm.robot for arm in arms if arm.joints]
    if len(robots) == 1:
        return {robots[0]: ""}
    names = [re.sub(r"[^\w.-]+", "-", robot[:LONGEST_PREFIX]).strip("-.") or "robot" for robot in robots]
    # Different arms may be alike as files are named.
    earlier = [names[:place].count(name) for place, name in enumerate(names)]
    numbers = [f"-{count + 1}" if count else "" for count in earlier]
    return {robot: f"{name}{number}-" for robot, name, number in zip(robots, names, numbers, strict=True)}
