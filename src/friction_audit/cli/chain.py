"""Log -> Estimate, as the commands run it: watched, and with the exit codes of the whole program."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from friction_audit.cli.console import DAMAGED, Voice
from friction_audit.errors import AnalysisError, UsageError

if TYPE_CHECKING:
    from friction_audit.audit import AuditSettings, Estimate
    from friction_audit.ingest import ReadOptions
    from friction_audit.joint_log import JointLog

TABLED = "not_determined"
"""Code of the caution that the table shows as well."""


def read(path: Path, options: "ReadOptions", voice: Voice) -> "JointLog":
    """Read a log and, if asked to, say how its columns were understood."""
    from friction_audit.ingest import read_log

    with voice.step(f"read {path}"):
        log = read_log(path, options)
    if voice.verbose:
        for channel, name in log.source.channels.items():
            typer.echo(f"channel {channel} = {name}", err=True)
    return log


def estimate(log: "JointLog", settings: "AuditSettings", voice: Voice) -> "Estimate":
    """Run the chain on a log."""
    from friction_audit.audit import estimate_log

    with voice.step("estimate friction"):
        return estimate_log(log, settings)


def reading_settings(options: "ReadOptions") -> dict[str, object]:
    """Return the reader's options for a document."""
    return asdict(options)


def warn_about(result: "Estimate", voice: Voice) -> None:
    """Say the warnings of a result that its table does not show."""
    from friction_audit.report.notices import estimate_notices

    voice.warn(str(notice) for notice in estimate_notices(result) if notice.code != TABLED)


def require_an_estimate(result: "Estimate") -> None:
    """Refuse a result without any coefficient.

    Raises:
        AnalysisError: With the reason of each joint.
    """
    joints = result.friction.joints
    if any(not joint.reason for joint in joints):
        return
    reasons: dict[str, list[int]] = {}
    for joint in joints:
        reasons.setdefault(joint.reason, []).append(joint.joint)
    lines = [f"{_name_joints(numbers)}: {reason}" for reason, numbers in reasons.items()]
    separator = "\n  "
    raise AnalysisError(f"{result.log.source.path}: no joint has an estimate:{separator}{separator.join(lines)}")


def exit_if_damaged(*logs: "JointLog") -> None:
    """Exit with the code for a result that part of the input is missing from."""
    if any(found.damaged for log in logs for found in log.source.findings):
        raise typer.Exit(DAMAGED)


def refuse_existing(paths: Sequence[Path], *, overwrite: bool) -> None:
    """Refuse to replace files, before anything long is done.

    Raises:
        UsageError: If one of the paths exists and may not be overwritten.
    """
    existing = [str(path) for path in paths if path.exists()]
    if existing and not overwrite:
        names = ", ".join(existing)
        raise UsageError(f"{names}: exists already; nothing was written; use --overwrite or another --output")


def _name_joints(numbers: list[int]) -> str:
    return f"joint{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"
