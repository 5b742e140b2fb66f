"""Sessions of a batch -> drift -> files in the folder of the ledger; loaded when an answer is made anew."""

import re
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

from friction_audit.batch.executor import Lost
from friction_audit.batch.run_batch import Standing, drift_of_arms, gather
from friction_audit.cli import chain
from friction_audit.cli.batch_report import RESULTS, Batch, BatchAnswer
from friction_audit.cli.console import DAMAGED, EXCEEDED, UNTESTABLE
from friction_audit.drift.report import ArmDrift
from friction_audit.errors import AnalysisError, InputError, few
from friction_audit.io.files import whole_file
from friction_audit.io.writers.tables import write_rows
from friction_audit.reporting.drift import BatchSummary, batch_lines, write_batch_document
from friction_audit.reporting.drift_sessions import session_columns
from friction_audit.reporting.drift_words import junit_text, limit_sentences, limits_beyond_all
from friction_audit.reporting.html.batch_page import draw, drawings_of, write_page
from friction_audit.reporting.html.page import Figure
from friction_audit.reporting.notices import reason_lines
from friction_audit.reporting.table import to_json

LONGEST_PREFIX = 60  # characters of an arm's name in the names of its files, which may have 255 bytes


def write_results(batch: Batch, standing: Standing, command: str) -> tuple[BatchAnswer, list[str]]:
    """Write the document, the tables, the page and the figures, each whole or not at all; return answer and files."""
    voice, folder = batch.voice, batch.folder
    with voice.step("look for drift"):
        summary = _summarise(batch, standing, command)
        junit = junit_text("batch-report", summary.arms, batch.limits) if batch.limits else ""
    with ThreadPoolExecutor(max_workers=1, thread_name_prefix="tables") as pool, voice.step("draw the figures"):
        tables = pool.submit(_write_tables, summary, folder)  # while others draw
        drawn, pictures = _draw(summary, batch)
        tables.result()
    with voice.step(f"write {RESULTS[1]}"), whole_file(folder / RESULTS[1], overwrite=True) as draft:
        draft.write_text(write_page(summary, pictures), encoding="utf-8")
    code = DAMAGED if summary.failed or any(session.damaged for session in summary.sessions) else 0
    if summary.exceeded or summary.cannot_tell:  # what was asked, the limits, comes before files that failed
        code = EXCEEDED if summary.exceeded else UNTESTABLE
    text = "".join(f"{line}\n" for line in batch_lines(summary, verbose=voice.verbose))
    codes = {session.path: session.codes for session in summary.sessions if session.codes}
    answer = BatchAnswer(text=text, warnings=summary.warnings, code=code, junit=junit, codes=codes)
    return answer, [*RESULTS, *drawn]


def _summarise(batch: Batch, standing: Standing, command: str) -> BatchSummary:
    sessions, failed, warnings = gather(standing, batch.settings, batch.ledger)
    if not sessions:
        lines = [f"{one.path}: {one.message}" for one in failed]
        raise InputError("\n  ".join([f"none of {len(lines)} logs can be used:", *few(lines)]))
    if all(joint.reason for session in sessions for joint in session.joints):
        lines = [f"{session.path}: {'; '.join(reason_lines(session.joints))}" for session in sessions]
        raise AnalysisError("\n  ".join(["no joint of any session has an estimate:", *few(lines)]))
    arms = drift_of_arms(sessions, batch.drift, batch.processes)
    asked = batch.settings
    every = {"reading": chain.reading_settings(asked.reading), **asdict(asked.audit), "drift": asdict(batch.drift)}
    every["diagnosis"] = None if asked.diagnosis is None else asdict(asked.diagnosis)
    beyond, unknown = limit_sentences(arms, batch.limits)
    warnings = (*warnings, *limits_beyond_all(arms, batch.limits))
    return BatchSummary(
        arms=arms, failed=failed, exceeded=beyond, cannot_tell=unknown, warnings=warnings,
        settings=to_json(every), command=command, computed=standing.new, known=standing.known,
    )  # fmt: skip


def _write_tables(summary: BatchSummary, folder: Path) -> None:
    document, _, *tables = (folder / name for name in RESULTS)
    with whole_file(document, overwrite=True) as draft, draft.open("w", encoding="utf-8") as file:
        file.writelines(write_batch_document(summary))
    for path in tables:
        with whole_file(path, overwrite=True) as draft:
            write_rows(*session_columns(summary.arms), draft, path.suffix.removeprefix("."))


def _draw(summary: BatchSummary, batch: Batch) -> tuple[list[str], dict[str, Figure]]:
    """Draw the figures side by side and write their files; return the names of those, and what is for the page."""
    names, pictures = [], {}
    drawings = drawings_of(summary.arms, _prefixes(summary.arms), batch.formats)
    for drawing, drawn in batch.processes.run(draw, drawings):
        if isinstance(drawn, Lost):
            raise AnalysisError(f"{drawing.name or drawing.anchor}: cannot be drawn: {drawn.message}")
        files, figure = drawn
        for name, content in files.items():
            with whole_file(batch.folder / name, overwrite=True) as draft:
                draft.write_bytes(content)
            names.append(name)
        if figure is not None:
            pictures[drawing.anchor] = figure
    return sorted(names), pictures


def _prefixes(arms: Sequence[ArmDrift]) -> dict[str, str]:
    """Return what the files of each arm that is drawn begin with: nothing for the only one, else its name."""
    robots = [arm.robot for arm in arms if arm.joints]
    if len(robots) == 1:
        return {robots[0]: ""}
    names = [re.sub(r"[^\w.-]+", "-", robot[:LONGEST_PREFIX]).strip("-.") or "robot" for robot in robots]
    # Different arms may be alike as files are named.
    alike = [names[: place + 1].count(name) for place, name in enumerate(names)]
    numbered = (f"{name}-{count}-" if count > 1 else f"{name}-" for name, count in zip(names, alike, strict=True))
    return dict(zip(robots, numbered, strict=True))
