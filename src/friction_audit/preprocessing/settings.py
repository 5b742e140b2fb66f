"""Settings of the interaction torque and of the segmentation into energy cycles."""

import shlex
from contextvars import ContextVar
from dataclasses import dataclass, fields
from math import inf, isfinite
from pathlib import Path

from friction_audit.errors import UsageError
from friction_audit.presets import PRESETS

GIVEN: ContextVar[str] = ContextVar("GIVEN", default="")
"""The command that a user gave, without the choices of the torque; empty where there is none."""
THRESHOLDS = ("fixed", "auto")
CYCLES_FROM = ("joint", "hand")


@dataclass(frozen=True, kw_only=True, slots=True)
class CycleSettings:
    """Settings of the segmentation; the defaults are the paper's (section V)."""

    thresholds: str = "fixed"  # ``"fixed"`` (the two below) or ``"auto"`` (from the log's own noise and speeds)
    initiation_rad_s: float = 0.2  # filtered speed above which a cycle begins [rad/s]
    termination_rad_s: float = 0.05  # filtered speed below which it ends [rad/s]
    cutoff_hz: float = 20.0  # corner of the low-pass filter on the velocity, for detection only [Hz]
    # ``"joint"``: each joint has its own cycles; ``"hand"``: the end effector's speed defines them
    cycles_from: str = "joint"
    hand_initiation_m_s: float = 0.1  # hand speed above which a cycle begins [m/s]
    hand_termination_m_s: float = 0.025  # hand speed below which it ends [m/s]
    # with ``"hand"``, a cycle counts only if every joint selected has moved this far [rad]
    minimum_path_rad: float = 0.1
    maximum_gap_s: float = 0.05  # a cycle with a longer hole in the log (and longer than 3.5 steps) is left out [s]
    closure_rad: float = 0.05  # a cycle whose ends are further apart is open in position [rad]

    def __post_init__(self) -> None:
        if self.thresholds not in THRESHOLDS:
            raise UsageError(f"--thresholds {self.thresholds}: expected one of {', '.join(THRESHOLDS)} or two numbers")
        if self.cycles_from not in CYCLES_FROM:
            raise UsageError(f"--cycles-from {self.cycles_from}: expected one of {', '.join(CYCLES_FROM)}")
        for option, start, stop, unit in (
            ("--thresholds", self.initiation_rad_s, self.termination_rad_s, "rad/s"),
            ("--hand-thresholds", self.hand_initiation_m_s, self.hand_termination_m_s, "m/s"),
        ):
            if not inf > start > stop > 0:
                raise UsageError(
                    f"{option} {start:g},{stop:g}: expected initiation above termination and both above zero, in {unit}"
                )
        if not inf > self.minimum_path_rad >= 0:
            raise UsageError(f"--min-path {self.minimum_path_rad:g}: expected an angle of zero or more, in rad")


TORQUES = ("auto", "interaction", "tau_ext", "tau_J")
GRAVITIES = ("auto", "in-torque", "removed", "logged", "model")
INERTIAS = ("auto", "model", "none")
DRIVES = ("auto", "hand", "robot")
ROBOTS = ("auto", *PRESETS, "none")
CHOICES = {"torque": TORQUES, "gravity": GRAVITIES, "inertia": INERTIAS, "drive": DRIVES, "robot": ROBOTS}


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueSettings:
    """Choices of the interaction torque; ``"auto"`` leaves them to the log."""

    torque: str = "auto"  # source channel, one of TORQUES
    gravity: str = "auto"  # where gravity comes from, one of GRAVITIES
    inertia: str = "auto"  # whether inertial and Coriolis torque is removed, one of INERTIAS
    drive: str = "auto"  # who moves the joint, one of DRIVES
    robot: str = "auto"  # which arm it is, and whose rigid-body model may be used, one of ROBOTS
    urdf: Path | None = None  # a URDF that replaces the built-in model, or None
    # mass [kg] and centre of mass x, y, z [m] in the flange frame, or None
    payload: tuple[float, float, float, float] | None = None
    gravity_vector: tuple[float, float, float] = (0.0, 0.0, -9.81)  # gravity in the base frame [m/s^2]
    model_rate_hz: float = 50.0  # rate at which its inertial torque and the speed of the hand are evaluated [Hz]

    def __post_init__(self) -> None:
        for name, allowed in CHOICES.items():
            if getattr(self, name) not in allowed:
                raise UsageError(f"--{name} {getattr(self, name)}: expected one of {', '.join(allowed)}")
        if not self.model_rate_hz > 0:
            raise UsageError(f"--model-rate {self.model_rate_hz:g}: expected a rate above zero, in Hz")
        if self.payload is not None and not (all(map(isfinite, self.payload)) and self.payload[0] > 0):
            raise UsageError(
                f"--payload {','.join(f'{value:g}' for value in self.payload)}: expected mass,x,y,z in kg and m with a "
                "mass above zero"
            )
        if not all(map(isfinite, self.gravity_vector)) or not any(self.gravity_vector):
            raise UsageError(
                f"--gravity-vector {','.join(f'{g:g}' for g in self.gravity_vector)}: expected three finite numbers, "
                "not all zero, in m/s^2; where nothing weighs, use --gravity removed"
            )

    def command(self, log: str, *more: str, **changed: str | None) -> str:
        """Return the command to paste that makes some choices otherwise: the user's own, else ``estimate`` of a log."""
        words = shlex.split(GIVEN.get()) or ["friction-audit", "estimate", log, *more]
        for one in fields(self):
            value = changed.get(one.name, getattr(self, one.name))
            if value != one.default:
                text = ",".join(f"{number:g}" for number in value) if isinstance(value, tuple) else str(value)
                option = "--" + one.name.removesuffix("_hz").replace("_", "-")
                words += [f"{option}={text}"] if text.startswith("-") else [option, text]
        return f"`{shlex.join(words)}`"
