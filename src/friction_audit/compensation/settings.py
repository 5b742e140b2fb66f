"""How a log is replayed: what is assumed of the person, which compensator runs, within which limits."""

from dataclasses import dataclass, field
from math import inf
from typing import Any

from friction_audit.compensation import ASSUMES, COMPETITORS, FEED_BACK, MODEL, SAME_MOTION, SAME_OPERATOR
from friction_audit.compensation.competitors import Compensator, DisturbanceObserver, TorqueRegulation
from friction_audit.compensation.law import Checked, EnergyCompensator, positive
from friction_audit.effects.joint_model import ArmModel, JointModel
from friction_audit.errors import UsageError
from friction_audit.presets import PRESETS

DEFAULT_MODEL = "combined"
# Twice the paper's: on a Panda's sensors, the difference of two cycles is noise as often as friction.
DEFAULT_WINDOW = {"combined": 4, "coulomb": 2, "viscous": 2}


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of what a compensator may command on one joint."""

    torque_nm: float = inf  # largest torque; infinite without a limit [N m]
    rate_nm_s: float = inf  # fastest change of it [N m/s]


def limits_of(robot: str, joint: int) -> Limits:
    """Return the limits of a joint, given by its number for people; none for an unknown arm."""
    preset = PRESETS.get(robot)
    if preset is None or not 1 <= joint <= len(preset.joints):
        return Limits()
    return Limits(torque_nm=preset.torque_nm[joint - 1], rate_nm_s=preset.torque_rate_nm_s)


@dataclass(frozen=True, kw_only=True, slots=True)
class Competitor:
    """Another compensator than the paper's, tuned from the log."""

    # one of COMPETITORS. ``"fixed"``: the coefficients of the whole log from the start. ``"sigmoid"``: as published for
    # a Panda, else nearest to the log's friction. ``"lugre"``: with the log's friction. ``"model"``: the friction of a
    # model file instead of the log's
    name: str
    observer_gain_per_s: float = 20.0  # of the disturbance observer [1/s]
    # as the compensator assumes it, or None for the inertia fitted to the log [kg m^2]
    motor_inertia_kg_m2: float | None = None
    desired_inertia_kg_m2: float | None = None  # of the torque regulation, or None for half the motor's [kg m^2]

    def __post_init__(self) -> None:
        if self.name not in COMPETITORS:
            raise UsageError(f"--compensator {self.name}: expected energy or one of {', '.join(COMPETITORS)}")


def energy_compensator(model: str = DEFAULT_MODEL, window: int | None = None, **kept: Any) -> EnergyCompensator:  # noqa: ANN401
    """Return the compensator of the paper with the default window of a log."""
    return EnergyCompensator(model=model, window=DEFAULT_WINDOW.get(model) if window is None else window, **kept)


@dataclass(frozen=True, kw_only=True, slots=True)
class OperatorImpedance:
    """A person's arm as one joint feels it."""

    inertia_kg_m2: float  # effective inertia [kg m^2]
    damping_nms_per_rad: float
    stiffness_nm_per_rad: float

    def __post_init__(self) -> None:
        numbers = (self.inertia_kg_m2, self.damping_nms_per_rad, self.stiffness_nm_per_rad)
        if not all(0 <= number < inf for number in numbers) or not any(numbers):
            raise UsageError(
                f"--operator {','.join(f'{number:g}' for number in numbers)}: expected inertia [kg m^2], damping "
                "[N m s/rad] and stiffness [N m/rad] of zero or more, at least one of them above"
            )


@dataclass(frozen=True, kw_only=True, slots=True)
class ModelFile:
    """Models of the joints of a log, and where they were read."""

    path: str  # of the file, as given
    model: ArmModel  # one model per joint of the log

    def joint(self, number: int) -> JointModel | None:
        """Return the model of a joint by its number for people, None where the file has none."""
        if number > len(self.model.joints):
            raise UsageError(
                f"--joint-model {self.path}: {len(self.model.joints)} joints, and the log has a joint {number}; give a "
                "model with an entry for every joint of the log"
            )
        return self.model.joints[number - 1]


class ReplaySettings(Checked):
    """Settings of a replay."""

    assume: str = SAME_MOTION  # ``"same-motion"``, ``"same-torque"`` or ``"same-operator"``
    # what runs on every joint; its thresholds give way to those of the segmentation
    compensator: Compensator = field(default_factory=energy_compensator)
    competitor: Competitor | None = None  # what runs instead, tuned from the log; None for ``compensator``
    # models of the joints, which move in place of those fitted to the log, and whose friction the competitor
    # ``"model"`` applies; None without a file
    joint_model: ModelFile | None = None
    # impedance of the person with ``"same-operator"``; None to fit it from the log
    operator: OperatorImpedance | None = None
    max_torque_nm: float | None = positive(None, high=inf)  # limit of the torque, or None for the arm's own [N m]
    max_torque_rate_nm_s: float | None = positive(None, high=inf)  # of its change, or None for the arm's own [N m/s]

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        if self.assume not in ASSUMES:
            raise UsageError(f"--assume {self.assume}: expected one of {', '.join(ASSUMES)}")
        if self.operator is not None and self.assume != SAME_OPERATOR:
            raise UsageError(f"--operator: not used with --assume {self.assume}; remove it or give same-operator")
        name = "" if self.competitor is None else self.competitor.name
        if name == MODEL and self.joint_model is None:
            raise UsageError(f"--compensator {MODEL}: applies the friction of a model file; give --joint-model FILE")
        if self.assume != SAME_MOTION:
            return
        if self.joint_model is not None and name != MODEL:
            raise UsageError(
                f"--joint-model {self.joint_model.path}: not used with --assume {self.assume} unless by --compensator "
                f"{MODEL}; remove it, or ask for either, or for --assume same-torque or same-operator"
            )
        if name in FEED_BACK or isinstance(self.compensator, DisturbanceObserver | TorqueRegulation):
            raise UsageError(
                "this compensator feeds the motion back, which --assume same-motion holds fixed; expected "
                "--assume same-torque or same-operator"
            )

    @property
    def needs_whole(self) -> bool:
        """Whether all samples are needed at once: where a joint moves otherwise, or a model of it is read."""
        return self.assume != SAME_MOTION or self.joint_model is not None

    def limits(self, own: Limits) -> Limits:
        """Return the limits in force, where the arm has its own."""
        return Limits(
            torque_nm=own.torque_nm if self.max_torque_nm is None else self.max_torque_nm,
            rate_nm_s=own.rate_nm_s if self.max_torque_rate_nm_s is None else self.max_torque_rate_nm_s,
        )
