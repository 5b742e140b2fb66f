"""``friction-audit batch-report``."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_audit import __version__
from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import Voice, remark, say
from friction_audit.cli.outputs import check_junit, write_junit
from friction_audit.cli.parameters import BATCH_FIGURES, DRIFT, RUNNING, SESSIONS, command_line, flag, group, option
from friction_audit.errors import UsageError, encodable, few

if TYPE_CHECKING:
    from friction_audit.batch.executor import Executor, LocalExecutor
    from friction_audit.batch.find_logs import LogFile
    from friction_audit.batch.ledger import BatchSettings, Ledger
    from friction_audit.batch.run_batch import Standing
    from friction_audit.drift.report import DriftSettings, Limit

EXAMPLES = """Examples:
  friction-audit batch-report logs/
  friction-audit batch-report 'logs/**/*.mcap' --manifest sessions.csv -o drift
  friction-audit batch-report logs/ --baseline 10 --fail-on coulomb=15% --quiet
  friction-audit batch-report s3://lab/panda/ --scheduler tcp://head:8786"""

INTERRUPTED = 130  # exit code: stopped by the user
# Parameters that change nothing in the numbers; the values of a --config file are written out.
NOT_PART_OF_IT = ("rebuild", "json", "quiet", "verbose", "overwrite", "config", "workers", "strict", "junit")
RESULTS = ("batch.json", "batch.html", "sessions.csv", "sessions.parquet")
"""In the folder of the ledger, made anew whenever something is new."""
_COUNTS = re.compile(r"\d+ computed, \d+ known")
_COUNT = re.compile(r' {2}"(computed|known)": \d+,\n')
# Notes of the ledger: which settings made the results in its folder, and what they are.
SETTINGS, REPORTED = "reported_settings", "reported"


@group(SESSIONS)
class SessionOptions:
    """What the sessions are."""

    manifest: Path | None = option(
        "Table with the columns path, start, robot, temperature, payload, note; paths are relative to it. Its logs "
        "are read too.", metavar="FILE.csv", exists=True, dir_okay=False,
    )  # fmt: skip
    diagnose: bool = flag("Also diagnose each session (slow).", "--diagnose")
    min_effect: opt.MinEffect = 0.0


@group(DRIFT)
class DriftOptions:
    """How drift is tested."""

    baseline: str = option("Reference: the first K sessions of each arm, or 3-8,10.", default="5", metavar="K|LIST")
    fail_on: opt.FailOn = None


@group(RUNNING)
class RunningOptions:
    """Where the work is done."""

    workers: int | None = option("Processes on this machine. Default: one per core.", metavar="N", min=1)
    scheduler: str | None = option("Dask cluster that does the work, e.g. tcp://host:8786.", metavar="ADDRESS")
    rebuild: bool = flag("Compute everything again; the existing ledger is kept under another name.", "--rebuild")

    def __post_init__(self) -> None:
        if self.workers is not None and self.scheduler is not None:
            both = f"--workers {self.workers} --scheduler {self.scheduler}"
            raise UsageError(f"{both}: a cluster has its own workers; give one")


def command(
    context: typer.Context,
    sessions: SessionOptions,
    drift: DriftOptions,
    running: RunningOptions,
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
    logs: Annotated[
        list[str] | None, typer.Argument(metavar="LOGS", help="Logs, folders (searched to the bottom), globs, URLs.")
    ] = None,
    folder: Path = opt.folder_option(f"Folder of ledger, {', '.join(RESULTS)} and figures.", Path("friction-drift")),
    formats: opt.FigureFormats = ["png"],
    junit: opt.JUnit = None,
    strict: opt.Strict = False,
) -> None:
    """Report friction drift across sessions: what changed, when."""
    from friction_audit.batch.executor import DaskExecutor, LocalExecutor
    from friction_audit.drift.report import DriftSettings, parse_baseline, parse_limit

    voice = shared.general.voice
    settings = _settings(sessions, friction, shared)
    tested = DriftSettings(baseline=parse_baseline(drift.baseline))
    limits = tuple(parse_limit(text) for text in drift.fail_on or ())
    check_junit(junit, limits, overwrite=shared.overwrite)
    found = _find(logs or [], sessions.manifest, folder)
    # With a cluster the processes of this machine only analyse arms and draw.
    processes = LocalExecutor() if running.workers is None else LocalExecutor(workers=running.workers)
    cluster = None if running.scheduler is None else DaskExecutor(address=running.scheduler)
    with _ledger(folder, running, voice) as (ledger, alone), processes:
        batch = Batch(folder, formats, ledger, settings, tested, limits, processes, voice)
        if not (shared.overwrite or running.rebuild or ledger.older):
            batch.check_results()
        standing = _catch_up(found, batch, cluster or processes, alone=alone)
        held = [(log.path, log.folders, log.row, standing.hashes.get(log.place)) for log in standing.logs]
        request = (held, standing.passing, standing.warnings, settings.text(), tested, limits, formats, __version__)
        last = batch.last()
        answer = None if shared.overwrite or voice.verbose else batch.recall(request, last)
        if answer is None:
            from friction_audit.cli.batch_files import write_results

            ledger.write_note(SETTINGS, settings.key())  # before anything of it is replaced
            again = encodable(command_line(context, leave_out=NOT_PART_OF_IT))
            answer, files = write_results(batch, standing, again)
            batch.remember(request, answer, files)
            batch.remove_figures(last, files)
    if shared.general.json:
        counts = {"computed": standing.new, "known": standing.known}  # of this run
        with (folder / RESULTS[0]).open(encoding="utf-8") as lines:
            for line in lines:
                count = _COUNT.fullmatch(line)
                say(line if count is None else f'  "{count[1]}": {counts[count[1]]},\n', nl=False)
    else:
        voice.warn(answer.warnings)
        say(_COUNTS.sub(f"{standing.new} computed, {standing.known} known", answer.text, count=1), nl=False)
    write_junit(junit, answer.junit, overwrite=shared.overwrite)
    chain.exit_if_strict(answer.codes, strict=strict)
    if answer.code:
        raise typer.Exit(answer.code)


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchAnswer:
    """What a batch answers beyond its JSON document; a note of the ledger holds it."""

    text: str  # table and sentences
    warnings: Sequence[str]
    code: int  # exit code
    junit: str  # the limits as JUnit; empty without one
    codes: Mapping[str, Sequence[str]]  # of the warnings of each session that has some, by its path


@dataclass(frozen=True, slots=True)
class Batch:
    """What is asked of a batch, and where it is done and kept."""

    folder: Path
    formats: Sequence[str]  # of the figures
    ledger: "Ledger"
    settings: "BatchSettings"
    drift: "DriftSettings"
    limits: "tuple[Limit, ...]"
    processes: "LocalExecutor"
    voice: Voice

    def check_results(self) -> None:
        """Refuse to replace results that this ledger and these settings did not make."""
        if self.ledger.note(SETTINGS) == self.settings.key():
            return
        figures = [f"*{kind}.{one}" for kind in BATCH_FIGURES for one in self.formats]
        drawn = sorted(path for figure in figures for path in self.folder.glob(figure))
        existing = [str(path) for path in (*(self.folder / name for name in RESULTS), *drawn) if path.exists()]
        if existing:
            raise UsageError(
                f"{', '.join(few(existing))}: made with other settings; nothing was computed; use "
                "--overwrite to replace them (the ledger keeps the numbers of both), or another folder with -o"
            )

    def last(self) -> dict[str, Any]:
        """Return the note on the last report: its request, its files and its answer; empty without one."""
        from friction_audit.batch.ledger import digest_of

        digest, _, text = (self.ledger.note(REPORTED) or "").partition(" ")
        if digest == (digest_of(repr(text)) if text else ""):
            note: dict[str, Any] = json.loads(text or "{}")
            return note
        why = "the note on the last report is damaged; the report is made again from the sessions"
        self.voice.warn([f"{self.ledger.path}: {why}"])
        return {}

    def recall(self, request: object, last: Mapping[str, Any]) -> BatchAnswer | None:
        """Return the answer to the same request if all that was written with it is still there, else None."""
        from friction_audit.batch.ledger import digest_of

        if last.get("request") != digest_of(repr(request)) or last["files"] != self._stamps(last["files"]):
            return None
        return BatchAnswer(**{name: last[name] for name in BatchAnswer.__slots__})

    def remember(self, request: object, answer: BatchAnswer, files: Iterable[str]) -> None:
        """Keep the answer to a request, and how the files look that were written with it."""
        from friction_audit.batch.ledger import digest_of

        text = json.dumps({"request": digest_of(repr(request)), "files": self._stamps(files)} | asdict(answer))
        self.ledger.write_note(REPORTED, f"{digest_of(repr(text))} {text}")

    def remove_figures(self, last: Mapping[str, Any], written: Sequence[str]) -> None:
        """Remove figures of the last report, as it left them, that this one has no content for."""
        before = last.get("files", {})
        for name, stamp in self._stamps(set(before).difference(written)).items():
            if stamp == before[name] and name.endswith(tuple(self.formats)):
                (self.folder / name).unlink()

    def _stamps(self, names: Iterable[str]) -> dict[str, list[int]]:
        """Return size and time of the last change of files, by name; of those that are there."""
        states = {name: (self.folder / name).stat() for name in names if (self.folder / name).exists()}
        return {name: [state.st_size, state.st_mtime_ns] for name, state in states.items()}


def _settings(sessions: SessionOptions, friction: opt.EstimateOptions, shared: opt.LogOptions) -> "BatchSettings":
    from friction_audit.batch.ledger import BatchSettings

    chain.refuse_join(shared.reading, "batch-report reads")
    diagnosis = None
    if sessions.diagnose:
        from friction_audit.diagnosis.settings import DiagnosisSettings

        diagnosis = DiagnosisSettings(min_effect_nm=sessions.min_effect)
    audit, reading = chain.audit_settings(shared, friction), chain.read_options(shared.reading, shared.selection)
    return BatchSettings(audit=audit, reading=reading, diagnosis=diagnosis)


def _find(names: list[str], manifest: Path | None, folder: Path) -> "list[LogFile]":
    from friction_audit.batch.find_logs import find_logs
    from friction_audit.batch.identity import read_manifest

    if not names and manifest is None:
        raise UsageError("no logs named; give files, folders, globs or URLs, or --manifest with their paths")
    if manifest is not None and manifest.resolve() in [(folder / name).resolve() for name in RESULTS]:
        raise UsageError(f"--manifest {manifest}: is a result of an earlier run; give a copy that is not replaced")
    rows = {} if manifest is None else read_manifest(manifest)
    return find_logs(names, rows, leave_out=[folder, *([manifest] if manifest else [])])


@contextmanager
def _ledger(folder: Path, running: RunningOptions, voice: Voice) -> "Iterator[tuple[Ledger, bool]]":
    """Open the ledger of a folder; yield it, and whether this is the only run in the folder."""
    from friction_audit.batch.find_logs import LEDGER
    from friction_audit.batch.ledger import Ledger, move_aside
    from friction_audit.batch.run_batch import run_lock

    path = folder / LEDGER
    chain.check_outputs([path], overwrite=True)
    folder.mkdir(parents=True, exist_ok=True)
    with run_lock(folder) as alone:
        if running.rebuild and not alone:
            raise UsageError(f"--rebuild: another run is at work in {folder}; wait for it or stop it")
        aside = move_aside(path) if running.rebuild else None
        with Ledger(path) as ledger:
            if aside := aside or ledger.older:
                voice.warn([f"the ledger that was there is kept as {aside}"])
            yield ledger, alone


def _catch_up(found: "Sequence[LogFile]", batch: Batch, executor: "Executor", *, alone: bool) -> "Standing":
    """Work on what is new, watched; stopped by the user, say how far it came."""
    from friction_audit.batch.run_batch import catch_up

    finished = "nothing is"

    def watch(done: int, total: int, failed: int) -> None:
        nonlocal finished
        finished = f"{done} of {total} new logs are"
        if report is not None:
            report(done / max(total, 1), f"{done}/{total}{f', {failed} failed' if failed else ''}")

    try:
        with batch.voice.step("estimate friction") as report:
            return catch_up(found, batch.settings, batch.ledger, executor, watch, backwards=not alone)
    except KeyboardInterrupt as stop:
        remark(f"stopped: {finished} finished; {batch.ledger.path} keeps them; the same command goes on from there")
        raise typer.Exit(INTERRUPTED) from stop
