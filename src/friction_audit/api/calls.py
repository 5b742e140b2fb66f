"""Read, estimate, replay, diagnose, report, simulate, write: one call each."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Unpack

from friction_audit import audit, export, ingest
from friction_audit.api.options import (
    DiagnosisOptions,
    EstimateOptions,
    ReadingOptions,
    ReplayOptions,
    audit_settings,
    check_names,
)
from friction_audit.audit import Diagnosis, Estimate, LogReplay
from friction_audit.discrepancy.settings import DiagnosisSettings
from friction_audit.errors import UsageError
from friction_audit.joint_log import JointLog
from friction_audit.replay.settings import ReplaySettings, energy_compensator
from friction_audit.report.log_report import LogReport, report_estimate
from friction_audit.simulate import SCENARIOS, Simulation, simulate
from friction_audit.simulate.hide import hide
from friction_audit.whole_file import whole_file


def read_log(path: str | Path, **options: Unpack[ReadingOptions]) -> JointLog:
    """Read a recorded joint log, whatever its format, and vet it.

    Args:
        path: A file, or the directory of a ROS 2 bag.
        options: How it is read: ``topic``, ``mapping`` of channels to names in the file, ``robot``, ``time_scale``,
            ``allow_short``, and the part from ``t_start_s`` to ``t_end_s``.

    Returns:
        The log, in SI units; what was noticed about it is in ``log.source.findings``.

    Raises:
        InputError: If it cannot be read as a joint log; the message says what was found and what to do.
    """
    check_names("read_log", options, ReadingOptions)
    return ingest.read_log(path, ingest.ReadOptions(**options))


def write_log(log: JointLog, path: str | Path, *, dialect: str | None = None, overwrite: bool = False) -> None:
    """Write a log whole or not at all, in the format that the ending of the name or the dialect says.

    Args:
        log: The log.
        path: Where to; a directory for ROS 2 bags.
        dialect: One of ``friction-audit convert --list-dialects``, or None for the first one of the ending.
        overwrite: Replace what is there.

    Raises:
        UsageError: If the dialect is unknown or cannot hold the log, or something is there.
    """
    export.write_log(log, Path(path), dialect=dialect, overwrite=overwrite)


def simulate_log(scenario: str, *, seed: int = 0, effects: Sequence[str] = (), **changes: object) -> Simulation:
    """Simulate a recording whose friction and hidden effects are known.

    Args:
        scenario: One of ``friction-audit simulate --list``, e.g. ``"panda-joint"``.
        seed: Seed of everything that is drawn; the same gives the same log to the bit.
        effects: Hidden effects as on the command line, e.g. ``"stribeck:excess_nm=0.1@1"``.
        changes: Settings of the scenario, e.g. ``duration_s=60.0``.

    Returns:
        ``log``, and in ``truth`` what the log does not say.

    Raises:
        UsageError: If there is no such scenario, setting or effect, or a value cannot be used.
    """
    named: dict[str, Any] = {one.name: one.settings for one in SCENARIOS}
    if scenario not in named:
        raise UsageError(f"{scenario}: no such scenario; expected one of {', '.join(named)}")
    check_names("simulate_log", changes, type(named[scenario]))
    # One effect alone is a sequence of letters to Python.
    hidden = (effects,) if isinstance(effects, str) else effects
    return simulate(hide(replace(named[scenario], **changes), hidden), seed, path=scenario)


def estimate_log(log: JointLog, **options: Unpack[EstimateOptions]) -> Estimate:
    """Estimate the friction of the joints of a log over time, with its uncertainty.

    Args:
        log: The log.
        options: ``joints`` by number from 1, ``t_start_s`` and ``t_stop_s``, and the settings of the torque (``drive``,
            ``gravity``, ``payload``, ...), the cycles (``thresholds``, ``cycles_from``, ...) and the estimate
            (``estimator``, ``model``, ``window``).

    Returns:
        The result of every step: ``interaction``, ``cycles``, ``friction``. A joint without an estimate is no error:
        its coefficients are NaN and ``reason`` says why.

    Raises:
        UsageError: If an option is unknown or contradicts the log, or it is no log.
        InputError: If the log lacks a channel that the options ask for.
    """
    if not isinstance(log, JointLog):
        raise UsageError(
            f"{type(log).__name__}: expected a log, as read_log returns it; read a file with read_log first"
        )
    return audit.estimate_log(log, audit_settings(options))


def replay_log(log: JointLog | Estimate, **options: Unpack[ReplayOptions]) -> LogReplay:
    """Run a friction compensator with a passivity controller on a log, as a controller would have.

    Args:
        log: A log, or what ``estimate_log`` made of it.
        options: ``assume``, ``compensator``, ``rival``, ``joint_model``, ``operator``, ``max_torque_nm``,
            ``max_torque_rate_nm_s``.

    Raises:
        UsageError: If an option is unknown, or options contradict each other or the log.
        AnalysisError: If the log cannot be replayed.
    """
    check_names("replay_log", options, ReplayOptions)
    estimate = _estimated(log)
    return audit.replay_estimate(estimate, replay_settings(estimate, options))


def diagnose_log(log: JointLog | Estimate, **options: Unpack[DiagnosisOptions]) -> Diagnosis:
    """Find what the model of each joint misses, name it, and measure how far the gap closes.

    Args:
        log: A log, or what ``estimate_log`` made of it.
        options: ``candidates``, ``alpha``, ``seed``, ``model``.

    Raises:
        UsageError: If an option is unknown or cannot be used.
        AnalysisError: If the log cannot be diagnosed.
    """
    check_names("diagnose_log", options, DiagnosisOptions)
    return audit.diagnose_estimate(_estimated(log), DiagnosisSettings(**options))


def report_log(log: JointLog | Estimate, path: str | Path | None = None, *, overwrite: bool = False) -> LogReport:
    """Put together all that a log says: friction, compensator, what the model misses.

    Args:
        log: A log, or what ``estimate_log`` made of it.
        path: Where to write it, or None; the ending says how: ``.html``, ``.pdf``, ``.md`` or ``.json``.
        overwrite: Replace what is there.

    Returns:
        The parts; one that the log gives no answer to is None, and ``unanswered`` says why.

    Raises:
        UsageError: If the ending is none of these, or something is there.
    """
    from friction_audit.report.report_bytes import REPORT_FORMATS

    if path is None:
        return _reported(log)
    writers, ending = dict(REPORT_FORMATS.values()), Path(path).suffix
    if ending.lower() not in writers:
        raise UsageError(f"{path}: ending {ending or 'missing'}: expected one of {', '.join(writers)}")
    # What cannot be written is refused before anything long is done.
    with whole_file(Path(path), overwrite=overwrite) as draft:
        report = _reported(log)
        draft.write_bytes(writers[ending.lower()](report))
    return report


def _reported(log: JointLog | Estimate) -> LogReport:
    estimate = _estimated(log)
    return report_estimate(estimate, replay_settings(estimate, {}), DiagnosisSettings())


def replay_settings(estimate: Estimate, options: ReplayOptions) -> ReplaySettings:
    """Return how an estimate is replayed: where the hand ends cycles, the compensator counts those that it does."""
    cycles = estimate.settings.cycles
    if "compensator" not in options and cycles.cycles_from == "hand":
        options = {**options, "compensator": energy_compensator(minimum_path_rad=cycles.minimum_path_rad)}
    return ReplaySettings(**options)


def _estimated(log: JointLog | Estimate) -> Estimate:
    return log if isinstance(log, Estimate) else estimate_log(log)
