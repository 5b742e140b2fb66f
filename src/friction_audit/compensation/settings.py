"""Settings of a replay: the assumption about the operator, the compensator, and the limits of its torque."""

from dataclasses import dataclass, field
from math import inf
from typing import Any

from friction_audit.compensation import ASSUMES, COMPETITORS, FEEDBACK, MODEL, SAME_MOTION, SAME_OPERATOR
from friction_audit.compensation.competitors import Compensator, DisturbanceObserver, TorqueRegulation
from friction_audit.compensation.law import Checked, EnergyCompensator, positive
from friction_audit.effects.joint_model import ArmModel, JointModel
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.preprocessing.interaction import Caution
from friction_audit.presets import PRESETS

DEFAULT_MODEL = "combined"
# Twice the paper's: with the noise of a Panda, the difference of two cycles is as often noise as friction.
DEFAULT_WINDOW = {"combined": 4, "coulomb": 2, "viscous": 2}


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of what a compensator may command on one joint."""

    torque_nm: float = inf  # largest torque; infinite without a limit [N m]
    rate_nm_s: float = inf  # largest rate of change of the torque [N m/s]


def limits_of(robot: str, joint: int) -> Limits:
    """Return the limits of a joint of an arm, by its number from 1; an unknown arm has none."""
    preset = PRESETS.get(robot)
    if preset is None or not 1 <= joint <= len(preset.joints):
        return Limits()
    return Limits(torque_nm=preset.torque_nm[joint - 1], rate_nm_s=preset.torque_rate_nm_s)


@dataclass(frozen=True, kw_only=True, slots=True)
class Competitor:
    """A compensator other than the paper's, tuned from the log."""

    # one of COMPETITORS. ``"fixed"``: the coefficients of the whole log. ``"sigmoid"``: as published for a Panda, else
    # fitted to the log's friction. ``"lugre"``: with the log's friction. ``"model"``: with the friction of a model file
    name: str
    observer_gain_per_s: float = 20.0  # of the disturbance observer [1/s]
    # assumed by the compensator, or None for the inertia fitted to the log [kg m^2]
    motor_inertia_kg_m2: float | None = None
    desired_inertia_kg_m2: float | None = None  # of the torque regulation, or None for half the motor's [kg m^2]

    def __post_init__(self) -> None:
        if self.name not in COMPETITORS:
            raise UsageError(f"--compensator {self.name}: expected energy or one of {', '.join(COMPETITORS)}")


def energy_compensator(model: str = DEFAULT_MODEL, window: int | None = None, **kept: Any) -> EnergyCompensator:  # noqa: ANN401
    """Return the compensator of the paper with the default window for a log."""
    return EnergyCompensator(model=model, window=DEFAULT_WINDOW.get(model) if window is None else window, **kept)


@dataclass(frozen=True, kw_only=True, slots=True)
class OperatorImpedance:
    """Mechanical impedance of the operator's arm at one joint."""

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

    path: str  # path of the file as given
    model: ArmModel  # one model per joint of the log

    def joint(self, number: int) -> JointModel:
        """Return the model of a joint by its number from 1; raise AnalysisError if the file has none."""
        if number > len(self.model.joints):
            raise UsageError(
                f"--joint-model {self.path}: {len(self.model.joints)} joints, and the log has a joint {number}; give a "
                "model with an entry for every joint of the log"
            )
        model = self.model.joints[number - 1]
        if model is None:
            raise AnalysisError((Caution("not_in_model_file"),))
        return model


class ReplaySettings(Checked):
    """Settings of a replay."""

    assume: str = SAME_MOTION  # ``"same-motion"``, ``"same-torque"`` or ``"same-operator"``
    # of every joint; its cycle thresholds are replaced by those of the segmentation
    compensator: Compensator = field(default_factory=energy_compensator)
    competitor: Competitor | None = None  # runs in place of ``compensator``, if given
    # joints that are simulated in place of those fitted to the log, and whose friction the competitor ``"model"``
    # applies; None without a file
    joint_model: ModelFile | None = None
    # impedance of the operator with ``"same-operator"``; None to fit it to the log
    operator: OperatorImpedance | None = None
    max_torque_nm: float | None = positive(None, high=inf)  # None for the arm's own limit [N m]
    max_torque_rate_nm_s: float | None = positive(None, high=inf)  # None for the arm's own limit [N m/s]

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
        if name in FEEDBACK or isinstance(self.compensator, DisturbanceObserver | TorqueRegulation):
            raise UsageError(
                "this compensator feeds the motion back, which --assume same-motion holds fixed; expected "
                "--assume same-torque or same-operator"
            )

    @property
    def needs_whole(self) -> bool:
        """Whether all samples are needed at once: for a simulated joint or a joint's model."""
        return self.assume != SAME_MOTION or self.joint_model is not None

    def limits(self, own: Limits) -> Limits:
        """Return the limits in force: the given ones, else the arm's own."""
        return Limits(
            torque_nm=own.torque_nm if self.max_torque_nm is None else self.max_torque_nm,
            rate_nm_s=own.rate_nm_s if self.max_torque_rate_nm_s is None else self.max_torque_rate_nm_s,
        )
