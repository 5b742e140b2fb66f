"""``friction-audit batch-report``."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit import __version__
from friction_audit.cli import chain
from friction_audit.cli import options as opt
from friction_audit.cli.batch_files import RESULTS, check_results, document_lines, recall_results, write_results
from friction_audit.cli.chain import audit_settings, read_options
from friction_audit.cli.choices import option
from friction_audit.cli.console import Voice, remark, say
from friction_audit.cli.grouped_help import DRIFT, RUNNING, SESSIONS, command_line
from friction_audit.cli.outputs import check_junit, write_junit
from friction_audit.drift.settings import DriftSettings, parse_baseline
from friction_audit.errors import AnalysisError, InputError, UsageError, encodable

if TYPE_CHECKING:
    from friction_audit.batch.executor import Executor, LocalExecutor
    from friction_audit.batch.find_logs import LogFile
    from friction_audit.batch.ledger import Ledger
    from friction_audit.batch.manifest import BatchSettings
    from friction_audit.batch.run_batch import BatchResult, Progress, Standing
    from friction_audit.drift.report import Limit
    from friction_audit.reporting.drift import BatchSummary

EXAMPLES = """Examples:
  friction-audit batch-report logs/
  friction-audit batch-report 'logs/**/*.mcap' --manifest sessions.csv -o drift
  friction-audit batch-report logs/ --baseline 10 --fail-on coulomb=15% --quiet
  friction-audit batch-report s3://lab/panda/ --scheduler tcp://head:8786"""

INTERRUPTED = 130  # exit code: stopped by the user
# Parameters that change nothing in the numbers; the values of a --config file are written out.
NOT_PART_OF_IT = ("rebuild", "json", "quiet", "verbose", "overwrite", "config", "workers", "strict", "junit")
# Modules that the drift and the results take, imported while others read logs.
FOR_RESULTS = (
    *("scipy.optimize", "scipy.signal", "scipy.stats", "statsmodels.robust.robust_linear_model"),
    *("statsmodels.stats.multitest", "friction_audit.io.writers.tables", "friction_audit.reporting.html.batch_page"),
    *("jinja2", "pyarrow.csv", "pyarrow.parquet"),
)
MOST_NAMED = 5  # logs that a message names; more are counted


@dataclass(frozen=True, kw_only=True, slots=True)
class SessionOptions:
    """What the sessions are."""

    manifest: Path | None = option(
        SESSIONS,
        "Table with the columns path, start, robot, temperature, payload, note; paths are relative to it. Its logs "
        "are read too.",
        metavar="FILE.csv",
        exists=True,
        dir_okay=False,
    )
    diagnose: bool = option(SESSIONS, "Also diagnose each session (slow).", "--diagnose", default=False)
    min_effect: opt.MinEffect = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class DriftOptions:
    """How drift is tested."""

    baseline: str = option(
        DRIFT,
        "Reference sessions: the first K of each arm, or their numbers, e.g. 3-8,10.",
        default="5",
        metavar="K|LIST",
    )
    fail_on: list[str] | None = opt.fail_on_option("coulomb=15%", "drifted", "sessions")


@dataclass(frozen=True, kw_only=True, slots=True)
class RunningOptions:
    """Where the work is done."""

    workers: int | None = option(RUNNING, "Processes on this machine. Default: one per core.", metavar="N", min=1)
    scheduler: str | None = option(
        RUNNING, "Scheduler of a Dask cluster that does the work instead, e.g. tcp://host:8786.", metavar="ADDRESS"
    )
    rebuild: bool = option(
        RUNNING, "Compute everything again; the existing ledger is kept under another name.", "--rebuild", default=False
    )

    def __post_init__(self) -> None:
        if self.workers is not None and self.scheduler is not None:
            raise UsageError(
                f"--workers {self.workers} --scheduler {self.scheduler}: a cluster has its own workers; give one"
            )


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
    folder: Path = opt.folder_option(
        f"Folder of the ledger, {', '.join(RESULTS)} and the figures.", default=Path("friction-drift")
    ),
    formats: opt.FigureFormats = ["png"],
    junit: opt.JUnit = None,
    strict: opt.Strict = False,
) -> None:
    """Report friction drift across sessions: what changed, when."""
    from friction_audit.batch.executor import DaskExecutor, LocalExecutor
    from friction_audit.drift.report import parse_limit
    from friction_audit.reporting.drift_text import junit_text

    voice = shared.general.voice
    settings = _settings(sessions, friction, shared)
    drift_settings = DriftSettings(baseline=parse_baseline(drift.baseline))
    limits = tuple(parse_limit(text) for text in drift.fail_on or ())
    check_junit(junit, limits, overwrite=shared.overwrite)
    found = _find(logs or [], sessions.manifest, folder)
    # With a cluster the processes of this machine only analyse arms and draw.
    processes = LocalExecutor() if running.workers is None else LocalExecutor(workers=running.workers)
    cluster = None if running.scheduler is None else DaskExecutor(address=running.scheduler)
    with _ledger(folder, running, voice) as (ledger, alone), processes:
        if not (shared.overwrite or running.rebuild or ledger.older):
            check_results(folder, formats, ledger, settings)
        standing = _catch_up(found, settings, ledger, cluster or processes, voice, alone=alone)
        request = (standing.digest(), settings.text(), drift_settings, limits, formats, __version__)
        answer = None if shared.overwrite or voice.verbose else recall_results(request, folder, ledger, voice)
        if answer is None:
            again = encodable(command_line(context, leave_out=NOT_PART_OF_IT))
            with voice.step("look for drift"):
                summary = _summarise(standing, settings, ledger, drift_settings, limits, again, processes)
                text = junit_text("batch-report", summary.report, limits) if limits else ""
            answer = write_results(summary, text, request, folder, formats, ledger, settings, processes, voice)
    if not shared.general.json:
        voice.warn(answer.warnings)
    for text in document_lines(folder, standing) if shared.general.json else (answer.text_of(standing),):
        say(text, nl=False)
    write_junit(junit, answer.junit, overwrite=shared.overwrite)
    chain.exit_if_strict(answer.codes, strict=strict)
    if answer.code:
        raise typer.Exit(answer.code)


def _settings(sessions: SessionOptions, friction: opt.EstimateOptions, shared: opt.LogOptions) -> "BatchSettings":
    from friction_audit.batch.manifest import BatchSettings

    chain.refuse_join(shared.reading, "batch-report reads")
    diagnosis = None
    if sessions.diagnose:
        from friction_audit.diagnosis.settings import DiagnosisSettings

        diagnosis = DiagnosisSettings(min_effect_nm=sessions.min_effect)
    reading = read_options(shared.reading, shared.selection)
    return BatchSettings(audit=audit_settings(shared, friction), reading=reading, diagnosis=diagnosis)


def _find(names: list[str], manifest: Path | None, folder: Path) -> "list[LogFile]":
    from friction_audit.batch.find_logs import find_logs
    from friction_audit.batch.manifest import read_manifest

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


def _catch_up(
    found: "Sequence[LogFile]",
    settings: "BatchSettings",
    ledger: "Ledger",
    executor: "Executor",
    voice: Voice,
    *,
    alone: bool,
) -> "Standing":
    """Work on what is new, watched; stopped by the user, say how far it came."""
    from friction_audit.batch.run_batch import catch_up

    last: list[Progress] = []

    def watch(progress: "Progress") -> None:
        last[:] = [progress]
        if progress.done == 1 < progress.total:
            loading.enter_context(chain.loading(*FOR_RESULTS))  # there is time while others read logs
        if count is not None:
            count(progress.done, progress.total, progress.failed)

    try:
        with ExitStack() as loading, voice.count("estimate friction") as count:
            return catch_up(found, settings, ledger, executor, watch, backwards=not alone)
    except KeyboardInterrupt as stop:
        done = f"{last[0].done} of {last[0].total} new logs are" if last else "nothing is"
        remark(f"stopped: {done} finished; {ledger.path} keeps them; the same command goes on from there")
        raise typer.Exit(INTERRUPTED) from stop


def _require_an_answer(result: "BatchResult") -> None:
    """Refuse a batch without a session, or without any coefficient in all of them, with the reasons."""
    from friction_audit.reporting.notices import reason_lines

    def named(lines: list[str]) -> str:
        more = [f"and {len(lines) - MOST_NAMED} more"] if len(lines) > MOST_NAMED else []
        return "".join(f"\n  {line}" for line in lines[:MOST_NAMED] + more)

    if not result.sessions:
        lines = [f"{failed.path}: {failed.message}" for failed in result.failed]
        raise InputError(f"none of {len(lines)} logs can be used:{named(lines)}")
    if all(joint.reason for session in result.sessions for joint in session.joints):
        lines = [f"{session.path}: {'; '.join(reason_lines(session.joints))}" for session in result.sessions]
        raise AnalysisError(f"no joint of any session has an estimate:{named(lines)}")


def _summarise(
    standing: "Standing",
    settings: "BatchSettings",
    ledger: "Ledger",
    drift: DriftSettings,
    limits: "tuple[Limit, ...]",
    command: str,
    processes: "LocalExecutor",
) -> "BatchSummary":
    from friction_audit.batch.run_batch import drift_of_arms, gather
    from friction_audit.reporting.drift import BatchSummary, FailedLog
    from friction_audit.reporting.drift_text import limit_sentences
    from friction_audit.reporting.table import to_json

    result = gather(standing, settings, ledger)
    _require_an_answer(result)
    report = drift_of_arms(result.sessions, drift, processes)
    every = {"reading": chain.reading_settings(settings.reading), **asdict(settings.audit), "drift": asdict(drift)}
    every["diagnosis"] = None if settings.diagnosis is None else asdict(settings.diagnosis)
    beyond, unknown = limit_sentences(report, limits)
    return BatchSummary(
        report=report,
        failed=tuple(FailedLog(path=failed.path, message=failed.message) for failed in result.failed),
        exceeded=beyond,
        cannot_tell=unknown,
        warnings=result.warnings,
        settings=to_json(every),
        command=command,
        computed=result.new,
        known=result.known,
    )
