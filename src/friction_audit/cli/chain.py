"""Log -> Estimate, as the commands run it: watched, and with the exit codes of the whole program."""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from friction_audit.cli import options as opt
from friction_audit.cli.console import DAMAGED, EXCEEDED, Voice, remark
from friction_audit.cli.parameters import parse_joints, parse_mapping, parse_numbers
from friction_audit.errors import AnalysisError, UsageError, few
from friction_audit.friction.settings import FrictionSettings
from friction_audit.io.files import check_place, keep_input
from friction_audit.joint_numbers import parse_joint_numbers
from friction_audit.parallel import aside, one_joint_at_a_time
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings

if TYPE_CHECKING:
    from friction_audit.diagnosis.result import JointDiagnosis
    from friction_audit.effects.joint_model import ArmModel
    from friction_audit.io.readers import Listen, ReadOptions
    from friction_audit.joint_log import JointLog
    from friction_audit.pipeline import AuditSettings, Estimate
    from friction_audit.reporting.notices import Joint, Notice
    from friction_audit.reporting.report import Unanswered


BUG = 1  # exit code: part of the result is missing because of a bug
LARGE_LOG = 1 << 26  # bytes of a file that takes about as long to read as compiled loops to load
FEW_SAMPLES = 40_000  # of a log whose joints take longer to share than to work through


@contextmanager
def loading(*modules: str) -> Iterator[None]:
    """Load modules during the work of a block; reading a log mostly waits for decoders that need no interpreter."""
    from friction_audit.compiled import load

    with ThreadPoolExecutor(max_workers=1, thread_name_prefix="import") as pool:
        for module in modules:
            pool.submit(load, module)
        yield


def read(
    path: Path, options: "ReadOptions", voice: Voice, listen: "Listen" = lambda _: None, loaded: Sequence[str] = ()
) -> "JointLog":
    """Read a log and, if asked to, say how its columns were understood; in a process of its own if modules are loaded.

    To load compiled loops takes the interpreter, for which reading would wait. A large log would be in memory twice.
    """
    from friction_audit.compiled import load
    from friction_audit.io.readers import read_log

    def work() -> "JointLog":
        return read_log(path, options, listen)

    is_apart = loaded and path.exists() and path.stat().st_size < LARGE_LOG
    with voice.step(f"read {path}"), aside(work) if is_apart else loading(*loaded) as result:
        for module in loaded if result else ():
            load(module)
        log = result() if result else work()
    if voice.verbose:
        for channel, name in log.source.channels.items():
            remark(f"channel {channel} = {name}")
    return log


def read_torque(path: Path, options: opt.LogOptions, voice: Voice) -> "JointLog":
    """Read a log for a result that is of no use where the torque is a motor current."""
    log = read(path, read_options(options.reading, options.selection), voice)
    if log.source.torque_unit != "N m":
        raise UsageError(
            f"{path}: its torque is a motor current [{log.source.torque_unit}]; expected newton metres; multiply the "
            "column by torque constant and gear ratio"
        )
    return log


def estimate(log: "JointLog", settings: "AuditSettings", voice: Voice) -> "Estimate":
    """Run the chain on a log."""
    from friction_audit.pipeline import estimate_log

    with voice.step("estimate friction"), one_joint_at_a_time() if log.samples < FEW_SAMPLES else nullcontext():
        return estimate_log(log, settings)


def reading_settings(options: "ReadOptions") -> dict[str, object]:
    """Return the reader's options for a document; the part of the log stands among the settings of the chain."""
    from friction_audit.io.readers.reader import OF_THE_COMMAND

    apart = ("t_start_s", "t_end_s", *OF_THE_COMMAND)
    # Conversions of the torque only where there are some.
    return {name: value for name, value in asdict(options).items() if name not in apart and value != ()}


def untabled(log: "JointLog", notices: "Iterable[Notice]", voice: Voice) -> "list[Notice]":
    """Return the notices that a result's table does not show."""
    from friction_audit.reporting.notices import TABLED, minor

    hidden = {*TABLED, *(() if voice.verbose else minor(log))}
    return [notice for notice in notices if notice.code not in hidden]


def warn_about(log: "JointLog", notices: "Iterable[Notice]", voice: Voice, *, marked: bool = False) -> None:
    """Say the warnings that a result's table does not show; ``marked``: it shows those about the physics."""
    from friction_audit.reporting.notices import NO_PHYSICS, notice_lines
    from friction_audit.reporting.words import MARK, count_of

    shown = untabled(log, notices, voice)
    data = notice_lines(one for one in shown if one.code in NO_PHYSICS)
    physics = notice_lines(one for one in shown if one.code not in NO_PHYSICS)
    kinds = [count_of(len(lines), f"{kind} warning") for lines, kind in ((data, "data"), (physics, "physics")) if lines]
    legend = f" (marked {MARK} below the table)" if marked and physics else ""
    total = f"{', '.join(kinds)}{legend}" if len(data + physics) > 1 or legend else ""
    voice.warn(data if marked else data + physics, total, held=True)


def require_one(log: "JointLog", joints: "Sequence[Joint]", lack: str = "no joint has an estimate") -> None:
    """Refuse a result in which every joint has a reason why it has none."""
    from friction_audit.reporting.notices import reason_lines

    if all(joint.reason for joint in joints):
        lines = "".join(f"\n  {line}" for line in reason_lines(joints))
        raise AnalysisError(f"{log.source.path}: {lack}:{lines}")


def conclude(log: "JointLog", notices: "Iterable[Notice]" = (), *, strict: bool = False) -> None:
    """Exit with the code for a result that stands: with doubts if that is asked for, or with input missing from it."""
    exit_if_strict({log.source.path: [one.code for one in notices]}, strict=strict)
    if any(found.damaged for found in log.source.findings):
        raise typer.Exit(DAMAGED)


def exit_if_strict(codes: Mapping[str, Iterable[str]], *, strict: bool) -> None:
    """If asked to, exit with the code of a limit where warnings of a log, by its path, are about the physics."""
    from friction_audit.reporting.notices import AS_ASKED, NO_PHYSICS

    sure = (*NO_PHYSICS, *AS_ASKED)
    doubts = {path: [one for one in some if one not in sure] for path, some in codes.items()}
    lines = [f"{path}: {', '.join(dict.fromkeys(some))}" for path, some in doubts.items() if some]
    if strict and lines:
        remark(
            f"error: --strict: warnings about the physics: {'; '.join(few(lines))}; expected none; the "
            "results are complete; do what the warnings say, or leave out --strict"
        )
        raise typer.Exit(EXCEEDED)


def exit_for_bugs(joints: "Iterable[JointDiagnosis]", voice: Voice, unanswered: "Iterable[Unanswered]" = ()) -> None:
    """Report joints, and parts of a report, that ended in a bug after the other results stand; exit as a bug does."""
    from friction_audit.reporting.notices import text_of

    bugs = [(one.message, one.traceback) for one in unanswered if one.traceback]
    bugs += [(f"joint {one.joint}: {text_of(one.reason)}", one.traceback) for one in joints if one.traceback]
    for sentence, traceback in bugs:
        remark(f"{traceback if voice.verbose else ''}error: {sentence}")
    if bugs:
        raise typer.Exit(BUG)


def check_outputs(paths: Sequence[Path], *, overwrite: bool, log: Path | None = None, folder: bool = False) -> None:
    """Refuse outputs (``folder``: folders) that could not be written or must not be, before anything long is done."""
    if log is not None:
        for path in paths:
            keep_input(path, log)
    existing = [str(path) for path in paths if os.path.lexists(path)]
    if existing and not overwrite:
        names = ", ".join(existing)
        raise UsageError(f"{names}: exists already; nothing was written; use --overwrite or another name")
    for path in paths:
        check_place(path, overwrite=overwrite, folder=folder)
    for place in dict.fromkeys(Path(os.path.realpath(path)).parent for path in paths):
        ground = next(parent for parent in (place, *place.parents) if os.path.lexists(parent))
        if not ground.is_dir() or not os.access(ground, os.W_OK):
            why = "read-only, or no permission" if ground.is_dir() else f"{ground} is a file"
            raise UsageError(f"{place}: cannot be written to ({why}); choose another place")


def check_joint_model(path: object, model: "ArmModel", log: "JointLog") -> None:
    """Refuse a model of another arm, before anything long is done."""
    if len(model.joints) != len(log.joint_names):
        raise UsageError(
            f"--joint-model {path}: {len(model.joints)} joints; {log.source.path} has {len(log.joint_names)}; "
            "give a model with an entry for every joint of the log"
        )


def refuse_join(reading: opt.ReadingOptions, what: str) -> None:
    """Refuse ``--join`` where several logs are read: its files are those of one log."""
    if reading.join:
        raise UsageError(
            f"--join {reading.join[0]}: {what} several logs; expected files of one log; join each with `friction-audit "
            "convert LOG OUT --join FILE` first"
        )


def read_options(reading: opt.ReadingOptions, selection: opt.SelectionOptions) -> "ReadOptions":
    """Return how the log is read, and which part of it."""
    from friction_audit.io.readers import ReadOptions

    given = asdict(reading)
    for name in ("torque_constant", "gear_ratio", "torque_scale"):
        text = given[name]
        each = ("X",) * len((text or "").split(","))
        given[name] = () if text is None else parse_numbers(f"--{name.replace('_', '-')}", text, each)
    given["mapping"], given["join"] = parse_mapping(reading.mapping), tuple(map(str, reading.join or ()))
    given["robot"] = None if reading.robot in ("auto", "none") else reading.robot
    given["flip"] = () if reading.flip is None else parse_joint_numbers(reading.flip, f"--flip {reading.flip}")
    return ReadOptions(**given, t_start_s=selection.t_start, t_end_s=selection.t_end)


def audit_settings(options: opt.LogOptions, estimate: opt.EstimateOptions | None = None) -> "AuditSettings":
    """Return the settings of the whole chain."""
    from friction_audit.pipeline import AuditSettings

    selection, cycles, given = options.selection, options.cycles, options.torque
    torque: dict[str, Any] = asdict(given)
    torque["model_rate_hz"] = torque.pop("model_rate")
    torque["gravity_vector"] = parse_numbers("--gravity-vector", given.gravity_vector, ("x", "y", "z"))
    if given.payload is not None:
        torque["payload"] = parse_numbers("--payload", given.payload, ("mass", "x", "y", "z"))
    begin, end = parse_numbers("--hand-thresholds", cycles.hand_thresholds, ("INIT", "TERM"))
    speeds: dict[str, Any] = {"thresholds": "auto", "hand_initiation_m_s": begin, "hand_termination_m_s": end}
    if cycles.thresholds != "auto":
        begin, end = parse_numbers("--thresholds", cycles.thresholds, ("INIT", "TERM"), "auto")
        speeds |= {"thresholds": "fixed", "initiation_rad_s": begin, "termination_rad_s": end}
    return AuditSettings(
        joints=parse_joints(selection.joints), t_start_s=selection.t_start, t_stop_s=selection.t_end,
        torque=TorqueSettings(robot=options.reading.robot, **torque),
        cycles=CycleSettings(cycles_from=cycles.cycles_from, minimum_path_rad=cycles.min_path, **speeds),
        friction=FrictionSettings(**asdict(estimate or opt.EstimateOptions())),
    )  # fmt: skip
