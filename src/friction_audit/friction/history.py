"""FrictionHistory: friction coefficients per joint over time, with their uncertainty."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isinf, isnan
from typing import Any, NamedTuple

import numpy as np

from friction_audit.joint_log import Float, Int
from friction_audit.preprocessing.interaction import Caution, Reason

NAN = float("nan")


@dataclass(frozen=True, kw_only=True, slots=True)
class Coefficient:
    """A value with its 95 % interval; NaN where the log (or the method) cannot give it."""

    value: float
    low: float
    high: float

    @classmethod
    def read(cls, found: Any) -> "Coefficient":  # noqa: ANN401 - any part of a document
        """Return a coefficient of a document: an object with its interval, a number, or null where it is not known.

        ValueError if a number is infinite or none.
        """
        one = found if isinstance(found, dict) else {"value": found}
        three = one["value"], *(one.get("ci95") or (None, None))
        value, low, high = (NAN if number is None else float(number) for number in three)
        if isinf(value) or isinf(low) or isinf(high):
            raise ValueError(found)
        return cls(value=value, low=low, high=high)

    def __str__(self) -> str:
        return "unknown" if isnan(self.value) else f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"

    @classmethod
    def around(cls, value: float, half: float = float("nan")) -> "Coefficient":
        """Return a value with an interval of a half width to either side."""
        return cls(value=float(value), low=float(value - half), high=float(value + half))

    def each(self, of: Callable[[float], Any]) -> "Coefficient":
        """Return a rising function of the value and of the ends of its interval."""
        return Coefficient(value=float(of(self.value)), low=float(of(self.low)), high=float(of(self.high)))


UNDETERMINED = Coefficient(value=NAN, low=NAN, high=NAN)
UNITS = {"coulomb": "nm", "viscous": "nms_per_rad"}


class Band(NamedTuple):
    """A coefficient over time and its 95 % intervals, shape (m,) each."""

    value: Float
    low: Float
    high: Float


class CoefficientHistory(NamedTuple):
    """Coefficients after each cycle that counts, m rows; NaN where a window cannot give one."""

    cycle: Int  # number of the cycle among all of the joint's cycles, from 1, shape (m,)
    start_s: Float  # start of the cycle [s]
    stop_s: Float  # stop of the cycle: the moment at which the estimate becomes known [s]
    coulomb: Band  # Coulomb coefficient [N m]
    viscous: Band  # viscous coefficient [N m s/rad]
    net_energy_j: Float  # net energy input since the first cycle's start, E_cyclic of the paper [J]
    dissipated_j: Float  # what friction took in this cycle, as the estimator counts it [J]
    path_rad: Float  # its path, the column of (18) that belongs to the Coulomb coefficient [rad]
    square_speed_rad2_s: Float  # integral of its squared velocity, the column of the viscous one [rad^2/s]


NONE, NO_BAND = np.empty(0), Band(*[np.empty(0)] * 3)
NO_HISTORY = CoefficientHistory(np.empty(0, np.int64), NONE, NONE, NO_BAND, NO_BAND, NONE, NONE, NONE, NONE)


class TorqueRegression(NamedTuple):
    """The same coefficients from a robust regression of the torque itself, for comparison."""

    coulomb: Coefficient  # Coulomb coefficient [N m]
    viscous: Coefficient  # viscous coefficient [N m s/rad]
    offset_nm: float  # constant part of the torque [N m]
    inertia: Coefficient  # coefficient of the acceleration [kg m^2]
    residual_rms_nm: float  # root mean square of what is left [N m]
    samples: int  # rows used
    condition_number: float = NAN  # of the scaled regression matrix
    correlation: float = NAN  # between the Coulomb and the viscous coefficient
    delay_s: float = NAN  # by which the torque is late after the motion, if that is certain [s]
    # Coulomb [N m] and viscous [N m s/rad] coefficient if friction may change slowly at reversals; None if it does not
    turning: tuple[float, float] | None = None
    # why it cannot stand alone for the friction of the joint; empty if it can, or if that was not asked
    doubt: Reason = ()


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointFriction:
    """Friction of one joint."""

    joint: int  # number for people
    name: str  # name in the log
    model: str  # ``"combined"``, ``"coulomb"`` or ``"viscous"``
    window: int  # cycles behind each point of the history, once there are so many
    cycles: int  # cycles that count
    rejected_cycles: int  # cycles left out
    moving_s: float  # time above the initiation threshold [s]
    coulomb: Coefficient = UNDETERMINED  # over the whole log [N m]
    viscous: Coefficient = UNDETERMINED  # over the whole log [N m s/rad]
    offset_nm: float = NAN  # torque offset fitted with them, NaN if not fitted [N m]
    gravity_error_nm: float = NAN  # amplitude of the gravity error fitted with them, NaN if not fitted [N m]
    condition_number: float = NAN  # of the scaled regression matrix
    correlation: float = NAN  # between the Coulomb and the viscous coefficient
    regression: TorqueRegression | None = None  # the torque-domain comparison, or None
    history: CoefficientHistory = NO_HISTORY  # coefficients over time
    reason: Reason = ()  # why there is no estimate; empty if there is one
    method: str = "energy"  # ``"energy"`` of the cycles, or ``"regression"`` of the torque where too few cycles count
    no_energy: Reason = ()  # why too few cycles count; empty where there is no regression in their place

    def __repr__(self) -> str:
        if self.reason:
            return f"joint {self.joint} {self.name}: no estimate: {'; '.join(map(str, self.reason))}"
        return f"joint {self.joint} {self.name}: Coulomb {self.coulomb}, viscous {self.viscous}, {self.cycles} cycles"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class FrictionHistory:
    """Friction of all joints of a log."""

    estimator: str
    joints: tuple[JointFriction, ...]
    warnings: tuple[Caution, ...] = ()
