"""BatchSummary -> files in the folder of its ledger."""

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.cli import choices
from friction_audit.cli.console import Voice
from friction_audit.cli.figure_files import draw_files
from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from friction_audit.batch.ledger import Ledger
    from friction_audit.batch.settings import BatchSettings
    from friction_audit.drift.report import ArmDrift
    from friction_audit.report.batch_summary import BatchSummary

DOCUMENT, PAGE, CSV, PARQUET = "batch.json", "batch.html", "sessions.csv", "sessions.parquet"
RESULTS = (DOCUMENT, PAGE, CSV, PARQUET)
"""Files beside the ledger, made anew in every run."""
REPORTED = "reported_settings"
"""Note of the ledger: which settings made the results that lie beside it."""


def check_results(
    folder: Path, formats: Sequence[str], ledger: "Ledger", settings: "BatchSettings", *, overwrite: bool
) -> None:
    """Refuse to replace results that this ledger and these settings did not make.

    Raises:
        UsageError: If there are some, and they may not be replaced.
    """
    if overwrite or ledger.note(REPORTED) == settings.key():
        return
    figures = [found for kind in choices.BATCH_FIGURES for one in formats for found in folder.glob(f"*{kind}.{one}")]
    existing = [str(path) for path in (*(folder / name for name in RESULTS), *sorted(figures)) if path.exists()]
    if existing:
        raise UsageError(
            f"{', '.join(existing)}: made with other settings; nothing was computed; use --overwrite to replace them "
            "(the ledger keeps the numbers of both), or another folder with -o"
        )


def write_results(
    summary: "BatchSummary",
    folder: Path,
    formats: list[str],
    ledger: "Ledger",
    settings: "BatchSettings",
    voice: Voice,
) -> str:
    """Write the document, the tables, the page and the figures, each whole or not at all; return the document."""
    from friction_audit.export.write_columns import write_columns
    from friction_audit.report.batch_document import batch_document
    from friction_audit.report.document import write_document
    from friction_audit.report.html.batch_page import write_page
    from friction_audit.report.session_table import COLUMNS, session_columns, session_csv
    from friction_audit.whole_file import whole_file

    document = write_document(batch_document(summary))
    ledger.write_note(REPORTED, settings.key())  # before anything of it is replaced
    for name, text in ((DOCUMENT, document), (CSV, session_csv(summary))):
        with whole_file(folder / name, overwrite=True) as draft:
            draft.write_text(text, encoding="utf-8")
    with whole_file(folder / PARQUET, overwrite=True) as draft:
        write_columns(session_columns(summary), COLUMNS, draft)
    with voice.step(f"write {PAGE}"), whole_file(folder / PAGE, overwrite=True) as draft:
        draft.write_text(write_page(summary), encoding="utf-8")
    _draw(summary, folder, formats, voice)
    return document


def _draw(summary: "BatchSummary", folder: Path, formats: list[str], voice: Voice) -> None:
    """Draw the figures of each arm that has joints to draw; of several arms under their names."""
    from friction_audit.report.figures.batch import BATCH_FIGURES

    arms = [arm for arm in summary.arms if arm.joints]
    for arm, prefix in zip(arms, _prefixes(arms), strict=True):
        kinds: dict[str, Callable[[int | None], Figure]] = {
            f"{prefix}{kind.name}": partial(kind.draw, arm) for kind in BATCH_FIGURES
        }
        numbers = [joint.joint for joint in arm.joints]
        draw_files(kinds, numbers, folder, formats, each_joint=False, overwrite=True, voice=voice)


def _prefixes(arms: "Sequence[ArmDrift]") -> list[str]:
    """Return what the files of each arm begin with: nothing for the only one, else its name as files are named."""
    if len(arms) == 1:
        return [""]
    names = [re.sub(r"[^\w.-]+", "-", arm.robot).strip("-.") or "robot" for arm in arms]
    return [f"{name}{_number(names[:place], name)}-" for place, name in enumerate(names)]


def _number(before: Sequence[str], name: str) -> str:
    """Return a number for names that are only the same as files are named."""
    return f"-{before.count(name) + 1}" if name in before else ""
