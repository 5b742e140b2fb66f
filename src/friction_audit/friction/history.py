"""FrictionHistory: friction coefficients per joint over time, with their uncertainty."""

from dataclasses import dataclass, fields, replace
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution


@dataclass(frozen=True, kw_only=True, slots=True)
class Coefficient:
    """A value with its 95 % interval; NaN where the log (or the method) cannot give it."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return "unknown" if isnan(self.value) else f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"


NAN = float("nan")
UNDETERMINED = Coefficient(value=NAN, low=NAN, high=NAN)
UNITS = {"coulomb": "nm", "viscous": "nms_per_rad"}


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class CoefficientHistory:
    """Coefficients after each cycle that counts, m rows; NaN where a window cannot give one.

    Attributes:
        cycle: Number of the cycle among all of the joint's cycles, from 1, shape (m,).
        start_s: Start of the cycle. [s]
        stop_s: Stop of the cycle: the moment at which the estimate becomes known. [s]
        coulomb_nm: Coulomb coefficient, shape (m,). [N m]
        coulomb_low_nm: Lower end of its 95 % interval.
        coulomb_high_nm: Upper end.
        viscous_nms_per_rad: Viscous coefficient. [N m s/rad]
        viscous_low_nms_per_rad: Lower end of its 95 % interval.
        viscous_high_nms_per_rad: Upper end.
        net_energy_j: Net energy input since the first cycle's start, E_cyclic of the paper. [J]
        dissipated_j: What friction took in this cycle, as the estimator counts it. [J]
        path_rad: Its path, the column of (18) that belongs to the Coulomb coefficient. [rad]
        square_speed_rad2_s: Integral of its squared velocity, the column of the viscous one. [rad^2/s]
    """

    cycle: NDArray[np.int64]
    start_s: Float
    stop_s: Float
    coulomb_nm: Float
    coulomb_low_nm: Float
    coulomb_high_nm: Float
    viscous_nms_per_rad: Float
    viscous_low_nms_per_rad: Float
    viscous_high_nms_per_rad: Float
    net_energy_j: Float
    dissipated_j: Float
    path_rad: Float
    square_speed_rad2_s: Float

    def of(self, name: str) -> tuple[Float, Float, Float]:
        """Return value, low and high of ``"coulomb"`` or ``"viscous"``, shape (m,) each."""
        value, low, high = (getattr(self, f"{name}{part}_{UNITS[name]}") for part in ("", "_low", "_high"))
        return value, low, high

    def with_coefficient(self, name: str, value: Float, low: Float, high: Float) -> "CoefficientHistory":
        """Return the history with another value, low and high of ``"coulomb"`` or ``"viscous"``."""
        unit = UNITS[name]
        changed: Any = {f"{name}_{unit}": value, f"{name}_low_{unit}": low, f"{name}_high_{unit}": high}
        return replace(self, **changed)


NO_HISTORY = CoefficientHistory(
    cycle=np.empty(0, np.int64), **{f.name: np.empty(0) for f in fields(CoefficientHistory) if f.name != "cycle"}
)


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueRegression:
    """The same coefficients from a robust regression of the torque itself, for comparison.

    Attributes:
        coulomb: Coulomb coefficient. [N m]
        viscous: Viscous coefficient. [N m s/rad]
        offset_nm: Constant part of the torque. [N m]
        inertia: Coefficient of the acceleration. [kg m^2]
        residual_rms_nm: Root mean square of what is left. [N m]
        samples: Rows used.
        condition_number: Of the scaled regression matrix.
        correlation: Between the Coulomb and the viscous coefficient.
        doubt: Why it cannot stand alone for the friction of the joint; empty if it can, or if that was not asked.
    """

    coulomb: Coefficient
    viscous: Coefficient
    offset_nm: float
    inertia: Coefficient
    residual_rms_nm: float
    samples: int
    condition_number: float = NAN
    correlation: float = NAN
    doubt: str = ""

    @property
    def inertia_kg_m2(self) -> float:
        """Value of the inertia. [kg m^2]"""
        return self.inertia.value


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointFriction:
    """Friction of one joint.

    Attributes:
        joint: Number for people.
        name: Name in the log.
        model: ``"combined"``, ``"coulomb"`` or ``"viscous"``.
        method: ``"energy"`` of the cycles, or ``"regression"`` of the torque where too few cycles count.
        window: Cycles behind each point of the history, once there are so many.
        cycles: Cycles that count.
        rejected_cycles: Cycles left out.
        moving_s: Time above the initiation threshold. [s]
        coulomb: Over the whole log. [N m]
        viscous: Over the whole log. [N m s/rad]
        offset_nm: Torque offset fitted with them, NaN if not fitted. [N m]
        gravity_error_nm: Amplitude of the gravity error fitted with them, NaN if not fitted. [N m]
        condition_number: Of the scaled regression matrix.
        correlation: Between the Coulomb and the viscous coefficient.
        regression: The torque-domain comparison, or None.
        history: Coefficients over time.
        reason: Why there is no estimate, as a sentence with the motion that would help; empty if there is one.
    """

    joint: int
    name: str
    model: str
    window: int
    cycles: int
    rejected_cycles: int
    moving_s: float
    coulomb: Coefficient = UNDETERMINED
    viscous: Coefficient = UNDETERMINED
    offset_nm: float = NAN
    gravity_error_nm: float = NAN
    condition_number: float = NAN
    correlation: float = NAN
    regression: TorqueRegression | None = None
    history: CoefficientHistory = NO_HISTORY
    reason: str = ""
    method: str = "energy"

    def __repr__(self) -> str:
        if self.reason:
            return f"joint {self.joint} {self.name}: no estimate: {self.reason.partition(';')[0]}"
        return (
            f"joint {self.joint} {self.name}: Coulomb {self.coulomb!s}, viscous {self.viscous!s}, {self.cycles} cycles"
        )


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class FrictionHistory:
    """Friction of all joints of a log."""

    estimator: str
    joints: tuple[JointFriction, ...]
    warnings: tuple[Caution, ...] = ()
