"""The names at the top of the package: they stay; everything else may move.

Every call raises ``UsageError`` for an option or a value that it cannot use; the message says which ones there are.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

from friction_audit import pipeline as audit
from friction_audit.compensation import settings as replaying
from friction_audit.compensation.competitors import Compensator
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import ArmModel
from friction_audit.errors import UsageError, near_misses
from friction_audit.friction.settings import FrictionSettings
from friction_audit.io import readers as ingest
from friction_audit.io.files import whole_file
from friction_audit.io.writers import write_log as export
from friction_audit.io.writers.tables import TidyTable, to_frame
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, Diagnosis, Estimate, LogReplay
from friction_audit.preprocessing.interaction import Caution
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from friction_audit.reporting import ENDINGS
from friction_audit.reporting.diagnosis import DIAGNOSE
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.figures import figures_of
from friction_audit.reporting.notices import sentence_of
from friction_audit.reporting.replay import REPLAY
from friction_audit.reporting.report import LogReport, report_estimate, report_tables
from friction_audit.simulation import Simulation, simulate
from friction_audit.simulation.hide import hide
from friction_audit.simulation.scenarios import find_scenario

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class ReadingOptions(TypedDict, total=False):
    """How a log is read: the fields of ``io.readers.ReadOptions``."""

    topic: str | None
    mapping: Mapping[str, str]
    robot: str | None
    time_scale: float
    allow_short: bool
    t_start_s: float | None
    t_end_s: float | None
    torque_constant: tuple[float, ...]
    gear_ratio: tuple[float, ...]
    torque_scale: tuple[float, ...]
    flip: tuple[int, ...]
    join: tuple[str, ...]


class EstimateOptions(TypedDict, total=False):
    """How friction is estimated: the fields of the settings of torque, cycles and estimate, and the part of the log."""

    joints: Sequence[int] | int | None
    t_start_s: float | None
    t_stop_s: float | None
    torque: str
    gravity: str
    inertia: str
    drive: str
    robot: str
    urdf: Path | None
    payload: tuple[float, float, float, float] | None
    gravity_vector: tuple[float, float, float]
    model_rate_hz: float
    thresholds: str
    initiation_rad_s: float
    termination_rad_s: float
    cutoff_hz: float
    cycles_from: str
    hand_initiation_m_s: float
    hand_termination_m_s: float
    minimum_path_rad: float
    maximum_gap_s: float
    closure_rad: float
    estimator: str
    model: str
    window: int | None
    compare: bool


class ReplayOptions(TypedDict, total=False):
    """How a log is replayed: the fields of ``compensation.settings.ReplaySettings``."""

    assume: str
    compensator: Compensator
    competitor: replaying.Competitor | None
    joint_model: replaying.ModelFile | None
    operator: replaying.OperatorImpedance | None
    max_torque_nm: float | None
    max_torque_rate_nm_s: float | None


class DiagnosisOptions(TypedDict, total=False):
    """What is asked of a diagnosis: the fields of ``diagnosis.settings.DiagnosisSettings``."""

    candidates: tuple[str, ...] | None
    min_effect_nm: float
    seed: int
    at_most_s: float
    model: ArmModel | None


def audit_settings(options: EstimateOptions) -> AuditSettings:
    """Return the settings of the chain; refuse options that there are not."""
    given: dict[str, Any] = dict(options)
    _check_names("estimate_log", given, EstimateOptions.__annotations__)
    if (joints := given.get("joints")) is not None:
        given["joints"] = (joints,) if isinstance(joints, int) else tuple(joints)
    steps: dict[str, Any] = {"torque": TorqueSettings, "cycles": CycleSettings, "friction": FrictionSettings}
    for step, settings in steps.items():
        own = {name: given.pop(name) for name in settings.__dataclass_fields__ if name in given}
        given[step] = settings(**own)
    return AuditSettings(**given)


def _check_names(call: str, given: Mapping[str, Any], names: Collection[str]) -> None:
    """Refuse options that a call does not know; the message names the near ones."""
    for name in given:
        if name not in names:
            raise UsageError(f"{call}: no option {name}; expected some of {', '.join(names)}{near_misses(name, names)}")


def read_log(path: str | Path, **options: Unpack[ReadingOptions]) -> JointLog:
    """Read a recorded joint log of any format, a file or the directory of a ROS 2 bag, into SI units, and check it.

    Options: ``topic``, ``mapping`` of channels to names in the file, ``join`` of further files, ``robot``,
    ``time_scale``, ``allow_short``, and the part from ``t_start_s`` to ``t_end_s``. What was noticed about the log is
    in ``log.source.findings``; what cannot be read as one raises ``InputError``, which says what was found.
    """
    _check_names("read_log", options, ReadingOptions.__annotations__)
    if not isinstance(path, str | PathLike):
        found = type(path).__name__
        raise UsageError(f"read_log: found a {found}, expected a path; log_from_frame reads frames and arrays")
    return ingest.read_log(path, ingest.ReadOptions(**options))


def log_from_frame(frame: Any, *, name: str = "frame", **options: Unpack[ReadingOptions]) -> JointLog:  # noqa: ANN401
    """Read a log from memory, with the names, units, options, checks and errors of ``read_log``.

    ``frame``: a pandas or polars DataFrame, or a dict of arrays by name, of shape (n,) or (n, joints); ``name``: what
    messages and results call it.
    """
    _check_names("log_from_frame", options, ReadingOptions.__annotations__)
    return ingest.log_from_frame(frame, ingest.ReadOptions(**options), name=name)


def write_log(log: JointLog, path: str | Path, *, dialect: str | None = None, overwrite: bool = False) -> None:
    """Write a log whole or not at all, in the format that the ending of the name or the dialect says.

    ``path``: a file, or a directory for ROS 2 bags; ``dialect``: one of ``friction-audit convert --list-dialects``.
    """
    export.write_log(log, Path(path), dialect=dialect, overwrite=overwrite)


def simulate_log(scenario: str, *, seed: int = 0, effects: Sequence[str] = (), **changes: object) -> Simulation:
    """Simulate a recording whose friction and hidden effects are known: ``log``, and the rest in ``truth``.

    ``scenario``: one of ``friction-audit simulate --list``, e.g. ``"panda-joint"``; ``changes``: its settings, e.g.
    ``duration_s=60.0``; ``effects``: as on the command line, e.g. ``"stribeck:excess_nm=0.1@1"``. The same ``seed``
    gives the same log to the bit.
    """
    settings: Any = find_scenario(scenario).settings
    _check_names("simulate_log", changes, settings.__dataclass_fields__)
    hidden = (effects,) if isinstance(effects, str) else effects  # one alone is a sequence of letters to Python
    return simulate(hide(replace(settings, **changes), hidden), seed, path=scenario)


def estimate_log(log: JointLog, **options: Unpack[EstimateOptions]) -> Estimate:
    """Estimate the friction of the joints of a log over time, with its uncertainty.

    Options: ``joints`` by number from 1, ``t_start_s`` and ``t_stop_s``, and the settings of the torque (``drive``,
    ``gravity``, ``payload``, ...), the cycles (``thresholds``, ``cycles_from``, ...) and the estimate (``estimator``,
    ``model``, ``window``). The result holds that of every step: ``interaction``, ``cycles`` (joint by joint),
    ``friction``. A joint without an estimate is no error: its coefficients are NaN and ``reason`` says why. A log that
    lacks a channel that the options ask for raises ``InputError``.
    """
    if not isinstance(log, JointLog):
        how = "pass its .log" if isinstance(log, Simulation) else "read a file with read_log first"
        raise UsageError(f"{type(log).__name__}: expected a log, as read_log returns it; {how}")
    return audit.estimate_log(log, audit_settings(options))


def replay_log(log: JointLog | Estimate, **options: Unpack[ReplayOptions]) -> LogReplay:
    """Run a friction compensator with a passivity controller on a log, as a controller would have.

    ``log``: a log, or what ``estimate_log`` made of it. Options: ``assume``, ``compensator``, ``competitor``,
    ``joint_model``, ``operator``, ``max_torque_nm``, ``max_torque_rate_nm_s``. Raises ``AnalysisError`` where the log
    cannot be replayed.
    """
    _check_names("replay_log", options, ReplayOptions.__annotations__)
    estimate = log if isinstance(log, Estimate) else estimate_log(log)
    return audit.replay_estimate(estimate, replay_settings(estimate, options))


def diagnose_log(log: JointLog | Estimate, **options: Unpack[DiagnosisOptions]) -> Diagnosis:
    """Find what the model of each joint misses, name it, and measure how far the gap closes.

    ``log``: a log, or what ``estimate_log`` made of it. Options: ``candidates``, ``min_effect_nm``, ``seed``,
    ``at_most_s``, ``model``. Raises ``AnalysisError`` where the log cannot be diagnosed.
    """
    _check_names("diagnose_log", options, DiagnosisOptions.__annotations__)
    estimate = log if isinstance(log, Estimate) else estimate_log(log)
    return audit.diagnose_estimate(estimate, DiagnosisSettings(**options))


def report_log(log: JointLog | Estimate, path: str | Path | None = None, *, overwrite: bool = False) -> LogReport:
    """Put together all that a log says: friction, compensator, what the model misses.

    ``log``: a log, or what ``estimate_log`` made of it; ``path``: where to write it, or None; the ending says how:
    ``.html``, ``.pdf``, ``.md`` or ``.json``. A part that the log gives no answer to is None; ``unanswered`` says why.
    """
    from friction_audit.reporting.html.log_page import WRITERS

    writers = {ENDINGS[kind]: content for kind, content in WRITERS.items()}
    ending = "" if path is None else Path(path).suffix
    if path is not None and ending.lower() not in writers:
        raise UsageError(f"{path}: ending {ending or 'missing'}: expected one of {', '.join(writers)}")
    # What cannot be written is refused before anything long is done.
    with nullcontext() if path is None else whole_file(Path(path), overwrite=overwrite) as draft:
        estimate = log if isinstance(log, Estimate) else estimate_log(log)
        report = report_estimate(estimate, replay_settings(estimate, {}), DiagnosisSettings())
        if draft is not None:
            draft.write_bytes(writers[ending.lower()](report))
    return report


def replay_settings(estimate: Estimate, options: ReplayOptions) -> replaying.ReplaySettings:
    """Return how an estimate is replayed: where the hand ends cycles, the compensator counts those that it does."""
    cycles = estimate.settings.cycles
    if "compensator" not in options and cycles.cycles_from == "hand":
        own = replaying.energy_compensator(minimum_path_rad=cycles.minimum_path_rad)
        options = {**options, "compensator": own}
    return replaying.ReplaySettings(**options)


def to_frames(result: Estimate | LogReplay | Diagnosis | LogReport) -> "dict[str, pd.DataFrame]":
    """Return the tables of a result by name, with units in the names of their columns.

    They are those that ``--export csv`` and ``--export parquet`` write: of an estimate ``coefficients``,
    ``coefficient_history``, ``cycles`` and ``interaction``; of a replay ``replay_joints``, ``replay_cycles`` and
    ``replay_signals``; of a diagnosis ``verdicts``, ``effects``, ``effect_parameters``, ``gap_ladder``,
    ``residual_profiles``, ``residual`` and ``simulated_motion``; of a report all of them.
    """
    return {table.name: to_frame(table) for table in _of_kind(result, "to_frames", TABLES)(result)}


def plot(
    result: Estimate | LogReplay | Diagnosis,
    kind: str | None = None,
    *,
    joint: int | None = None,
    ax: "Axes | None" = None,
) -> "Figure | Axes":
    """Draw a result, as ``friction-audit plot`` does, or one joint of it into axes of yours.

    ``kind``: ``"velocity-torque"``, ``"replay-velocity-torque"`` or ``"ladder"``, None for the one that fits the
    result; without ``ax`` any of ``friction-audit plot --help``. ``joint``: its number (1..n), None for all; with
    ``ax`` one joint. Your rcParams hold in the axes, and in the figure without them, which is unknown to pyplot.
    """
    own = {figure.name: figure for figure in figures_of(_of_kind(result, "plot", DRAWN))}
    panels = [name for name, figure in own.items() if figure.panel]
    figure = own.get(kind or panels[0])
    if figure is None or (ax is not None and not figure.panel):
        reason = f"expected one of {', '.join(own)}" if figure is None else f"into axes goes {', '.join(panels)} alone"
        raise UsageError(f"plot: {kind}: {reason}")
    from friction_audit.reporting.figures.panels import label_in_unit
    from friction_audit.reporting.figures.style import STYLE, style_in_force

    estimate = result if isinstance(result, Estimate) else result.estimate
    if ax is None:
        token = STYLE.set(style_in_force())
        try:
            drawn: Figure | Axes = figure.draw(result, joint)
        finally:
            STYLE.reset(token)
    else:
        held = [one.joint for one in estimate.friction.joints]
        if joint is None and len(held) > 1:
            raise UsageError(f"plot: {len(held)} joints and one panel; choose one with joint={held[0]} ... {held[-1]}")
        figure.layout().into(ax, result, held[0] if joint is None else joint)
        drawn = ax
    return label_in_unit(drawn, estimate.log.source.torque_unit)


DRAWN: dict[type, str] = {Estimate: "estimate", LogReplay: "replay", Diagnosis: "diagnosis"}
TABLES: dict[type, Callable[[Any], Sequence[TidyTable]]] = {Estimate: ESTIMATE.tables, LogReplay: REPLAY.tables}
TABLES |= {Diagnosis: DIAGNOSE.tables, LogReport: report_tables}


def _of_kind(result: object, call: str, kinds: Mapping[type, Any]) -> Any:  # noqa: ANN401 - of any kind
    if type(result) in kinds:
        return kinds[type(result)]
    calls = f"estimate_log, replay_log{', diagnose_log or report_log' if LogReport in kinds else ' or diagnose_log'}"
    raise UsageError(f"{call}: {type(result).__name__}: expected the result of {calls}; call one of them first")


audit.Shown.draw, audit.Shown.tables = staticmethod(plot), staticmethod(to_frames)
Caution.words = staticmethod(sentence_of)
