"""What the calls may be told by keyword: the settings of the steps under their own names.

A test holds them equal to the settings that they become.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypedDict

from friction_audit.audit import AuditSettings
from friction_audit.cycles.settings import CycleSettings
from friction_audit.errors import UsageError
from friction_audit.friction.settings import FrictionSettings
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.model.joint_model import ArmModel
from friction_audit.replay.compensators import Compensator
from friction_audit.replay.rivals import Rival
from friction_audit.replay.settings import ModelFile, OperatorImpedance


class ReadingOptions(TypedDict, total=False):
    """How a log is read: the fields of ``ingest.ReadOptions``."""

    topic: str | None
    mapping: Mapping[str, str]
    robot: str | None
    time_scale: float
    allow_short: bool
    t_start_s: float | None
    t_end_s: float | None


class EstimateOptions(TypedDict, total=False):
    """How friction is estimated: the fields of the settings of torque, cycles and estimate, and the part of the log."""

    joints: Sequence[int] | None
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
    """How a log is replayed: the fields of ``replay.settings.ReplaySettings``."""

    assume: str
    compensator: Compensator
    rival: Rival | None
    joint_model: ModelFile | None
    operator: OperatorImpedance | None
    max_torque_nm: float | None
    max_torque_rate_nm_s: float | None


class DiagnosisOptions(TypedDict, total=False):
    """What is asked of a diagnosis: the fields of ``discrepancy.settings.DiagnosisSettings``."""

    candidates: tuple[str, ...] | None
    alpha: float
    seed: int
    model: ArmModel | None


SELECTION = ("joints", "t_start_s", "t_stop_s")
"""Options that are settings of the chain itself."""


def audit_settings(options: EstimateOptions) -> AuditSettings:
    """Return the settings of the chain.

    Raises:
        UsageError: If there is no such option, or a value cannot be used.
    """
    given: dict[str, Any] = dict(options)
    check_names("estimate_log", given, EstimateOptions)
    joints = given.get("joints")
    chosen = {name: given[name] for name in SELECTION if name in given}
    return AuditSettings(
        **chosen | {"joints": None if joints is None else tuple(joints)},
        torque=TorqueSettings(**_own(given, TorqueSettings)),
        cycles=CycleSettings(**_own(given, CycleSettings)),
        friction=FrictionSettings(**_own(given, FrictionSettings)),
    )


def check_names(call: str, given: Mapping[str, Any], known: type) -> None:
    """Refuse options that a call does not know.

    Raises:
        UsageError: If there are some; the message names the near ones.
    """
    from difflib import get_close_matches

    names = tuple(known.__annotations__)
    for name in given:
        if name not in names:
            near = get_close_matches(name, names, n=2)
            hint = f"; did you mean {' or '.join(near)}?" if near else ""
            raise UsageError(f"{call}: no option {name}; expected some of {', '.join(names)}{hint}")


def _own(given: Mapping[str, Any], settings: Any) -> dict[str, Any]:  # noqa: ANN401 - a dataclass
    from dataclasses import fields

    return {f.name: given[f.name] for f in fields(settings) if f.name in given}
