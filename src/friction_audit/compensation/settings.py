"""How a log is replayed."""

from dataclasses import dataclass, field
from typing import Any

from friction_audit.compensation.compensators import (
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    TorqueRegulation,
)
from friction_audit.compensation.limits import ASSUMPTIONS, SAME_MOTION, SAME_OPERATOR, Limits
from friction_audit.compensation.rivals import FEED_BACK, MODEL, Rival
from friction_audit.effects.joint_model import ArmModel, JointModel
from friction_audit.errors import UsageError

DEFAULT_MODEL = "combined"
DEFAULT_WINDOW = {"combined": 4, "coulomb": 2, "viscous": 2}
"""Twice the paper's: on a Panda's sensors, what two cycles tell apart is noise as often as friction."""


def energy_compensator(model: str = DEFAULT_MODEL, window: int | None = None, **kept: Any) -> EnergyCompensator:  # noqa: ANN401
    """Return the compensator of the paper with the default window of a log.

    Args:
        model: Friction model.
        window: Cycles per estimate, or None for the default.
        kept: Its other settings.
    """
    return EnergyCompensator(model=model, window=DEFAULT_WINDOW.get(model) if window is None else window, **kept)


@dataclass(frozen=True, kw_only=True, slots=True)
class OperatorImpedance:
    """A person's arm as one joint feels it.

    Attributes:
        inertia_kg_m2: Effective inertia. [kg m^2]
        damping_nms_per_rad: [N m s/rad]
        stiffness_nm_per_rad: [N m/rad]

    Raises:
        UsageError: If a number is negative or not finite, or all are zero.
    """

    inertia_kg_m2: float
    damping_nms_per_rad: float
    stiffness_nm_per_rad: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        numbers = (self.inertia_kg_m2, self.damping_nms_per_rad, self.stiffness_nm_per_rad)
        if not all(0 <= number < float("inf") for number in numbers) or not any(numbers):
            raise UsageError(
                f"--operator {','.join(f'{number:g}' for number in numbers)}: expected inertia [kg m^2], damping "
                "[N m s/rad] and stiffness [N m/rad] of zero or more, at least one of them above"
            )


@dataclass(frozen=True, kw_only=True, slots=True)
class ModelFile:
    """Models of the joints of a log, and where they were read.

    Attributes:
        path: Of the file, as given.
        model: One model per joint of the log.
    """

    path: str
    model: ArmModel

    def joint(self, number: int) -> JointModel | None:
        """Return the model of a joint by its number for people, None where the file has none.

        Raises:
            UsageError: If the log has more joints than the file.
        """
        if number > len(self.model.joints):
            raise UsageError(
                f"--joint-model {self.path}: {len(self.model.joints)} joints, and the log has a joint {number}; give a "
                "model with an entry for every joint of the log"
            )
        return self.model.joints[number - 1]


@dataclass(frozen=True, kw_only=True, slots=True)
class ReplaySettings:
    """Settings of a replay.

    Attributes:
        assume: ``"same-motion"``, ``"same-torque"`` or ``"same-operator"``.
        compensator: What runs on every joint; its thresholds give way to those of the segmentation.
        rival: What runs instead, tuned from the log; None for ``compensator``.
        joint_model: Models of the joints, which move in place of those fitted to the log, and whose friction the rival
            ``"model"`` applies; None without a file.
        operator: Impedance of the person with ``"same-operator"``; None to fit it from the log.
        max_torque_nm: Limit of the torque, or None for the arm's own. [N m]
        max_torque_rate_nm_s: Limit of its change, or None for the arm's own. [N m/s]

    Raises:
        UsageError: If a name is unknown or settings contradict each other.
    """

    assume: str = SAME_MOTION.name
    compensator: Compensator = field(default_factory=energy_compensator)
    rival: Rival | None = None
    joint_model: ModelFile | None = None
    operator: OperatorImpedance | None = None
    max_torque_nm: float | None = None
    max_torque_rate_nm_s: float | None = None

    def __post_init__(self) -> None:
        """Check names and contradictions."""
        if self.assume not in ASSUMPTIONS:
            raise UsageError(f"--assume {self.assume}: expected one of {', '.join(ASSUMPTIONS)}")
        if self.operator is not None and self.assume != SAME_OPERATOR.name:
            raise UsageError(
                f"--operator: not used with --assume {self.assume}; leave it away or ask for --assume same-operator"
            )
        self._check_model()
        self.limits(Limits())
        feeds_back = self.rival is not None and self.rival.name in FEED_BACK
        feeds_back = feeds_back or isinstance(self.compensator, DisturbanceObserver | TorqueRegulation)
        if self.assume == SAME_MOTION.name and feeds_back:
            raise UsageError(
                "this compensator feeds the motion back, which --assume same-motion holds fixed; expected "
                "--assume same-torque or same-operator"
            )

    def _check_model(self) -> None:
        applied = self.rival is not None and self.rival.name == MODEL
        if applied and self.joint_model is None:
            raise UsageError(
                f"--compensator {MODEL}: applies the friction of a model file; give it by --joint-model FILE"
            )
        if self.joint_model is not None and self.assume == SAME_MOTION.name and not applied:
            raise UsageError(
                f"--joint-model {self.joint_model.path}: not used with --assume {self.assume} unless by --compensator "
                f"{MODEL}; leave it away, or ask for either, or for --assume same-torque or same-operator"
            )

    def limits(self, own: Limits) -> Limits:
        """Return the limits in force, where the arm has its own."""
        return Limits(
            torque_nm=own.torque_nm if self.max_torque_nm is None else self.max_torque_nm,
            rate_nm_s=own.rate_nm_s if self.max_torque_rate_nm_s is None else self.max_torque_rate_nm_s,
        )
