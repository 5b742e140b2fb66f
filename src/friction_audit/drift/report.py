"""DriftReport: what changed between sessions, when, and how sure we are."""

from dataclasses import dataclass

from friction_audit.drift.session import Session
from friction_audit.friction.history import UNDETERMINED, Coefficient

# What describes a coefficient over the sessions. "step_or_ramp": drift is proven, but the two describe it equally well.
# "temperature": it changes together with the temperature, so that drift and temperature are confounded.
SHAPES = ("none", "step", "steps", "ramp", "step_or_ramp", "temperature", "too_few")


@dataclass(frozen=True, kw_only=True, slots=True)
class ChangePoint:
    """A step between two sessions.

    Attributes:
        session: Index into ``ArmDrift.sessions`` of the first one after the step.
        low: First session that may be the first one after the step, same index, 95 % interval.
        high: Last one.
        before: Level before it, with interval.
        after: Level after it.
        relative: Change over the level before it, with interval; NaN where that level is near zero.
        p_value: Family-wise over joints and coefficients of the arm.
    """

    session: int
    low: int
    high: int
    before: Coefficient
    after: Coefficient
    relative: Coefficient
    p_value: float


@dataclass(frozen=True, kw_only=True, slots=True)
class ControlPoint:
    """One session against the reference.

    Attributes:
        session: Index into ``ArmDrift.sessions``.
        deviation: Deviation from the reference's level; its interval is where a session without drift would lie, 0 in
            its middle (family-wise over the sessions). Unit of the coefficient.
        relative: The same over the reference's level; NaN where that is near zero.
        outside: Whether the deviation lies outside of the limits.
    """

    session: int
    deviation: Coefficient
    relative: Coefficient
    outside: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class CoefficientDrift:
    """One coefficient of one joint over the sessions; every interval is of 95 %.

    Attributes:
        coefficient: ``"coulomb_nm"`` or ``"viscous_nms_per_rad"``.
        sessions: Indices into ``ArmDrift.sessions`` of those that were compared.
        values: The coefficient in each of them, as compared (at like temperature), with its own interval.
        isolated: Those of ``sessions`` that none of their neighbours comes near: shown, but not counted as drift.
        level: Level in the reference. Unit of the coefficient.
        shape: What describes it: one of ``SHAPES``.
        p_value: That nothing changes, family-wise over joints and coefficients of the arm.
        temperature_slope: Relative change per degree that was taken out, NaN where none could be. [1/K]
        temperature_c: Temperature that the values are compared at, NaN where none could be. [degC]
        trend_per_session: Robust slope, unit of the coefficient per session.
        trend_per_day: The same per day; NaN where starts are not known.
        trend_p_value: That there is no straight trend, family-wise.
        change_points: Steps, in order; empty where a ramp describes it.
        control: Every session against the reference.
        change: From the reference to the last sessions, unit of the coefficient.
        total: The same over the reference's level; NaN where that is near zero.
        scatter: Standard deviation between sessions beyond the intervals of the estimates, over the level (in the unit
            of the coefficient where the level is near zero).
        smallest_change: Straight change, start to end, that so many sessions would have shown with 90 % power, unit of
            the coefficient.
        smallest_drift: The same over the level; NaN where that is near zero.
        within: Relative change within a session (warm-up), over all sessions that have one; no part of the drift.
        drift: Whether there is any.
        warmer_k: Rise of the temperature from the first to the last sessions, NaN where it is not known. [K]
        by_temperature: Whether there is a change that the temperature explains.
        speed_ratio: Speed of motion at the end of a change over its start, where it went with it, else NaN.
        reasons: Why sessions have no estimate, where there are too few.
    """

    coefficient: str
    sessions: tuple[int, ...]
    values: tuple[Coefficient, ...]
    isolated: tuple[int, ...] = ()
    level: Coefficient = UNDETERMINED
    shape: str = "none"
    p_value: float = 1.0
    temperature_slope: Coefficient = UNDETERMINED
    temperature_c: float = float("nan")
    trend_per_session: Coefficient = UNDETERMINED
    trend_per_day: Coefficient = UNDETERMINED
    trend_p_value: float = 1.0
    change_points: tuple[ChangePoint, ...] = ()
    control: tuple[ControlPoint, ...] = ()
    change: Coefficient = UNDETERMINED
    total: Coefficient = UNDETERMINED
    scatter: float = float("nan")
    smallest_change: float = float("nan")
    smallest_drift: float = float("nan")
    within: Coefficient = UNDETERMINED
    drift: bool
    warmer_k: float = float("nan")
    by_temperature: bool = False
    speed_ratio: float = float("nan")
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class JointDrift:
    """One joint over the sessions.

    Attributes:
        joint: Number for people.
        name: Its name.
        coefficients: What became of each coefficient.
        drift: Whether one of them drifts.
    """

    joint: int
    name: str
    coefficients: tuple[CoefficientDrift, ...]
    drift: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class ArmDrift:
    """One arm.

    Attributes:
        robot: Which arm.
        sessions: All its sessions in the order of their starts (of their names where starts are not known).
        compared: Indices of those that were compared.
        reference: Indices of the sessions of the reference.
        left_out: Index of each session that was not compared, with the reason.
        joints: What became of each joint.
        ordered_by: ``"start"`` or ``"name"``.
        autocorrelation: Of one session's scatter with the next one's, over all joints.
        drift: Whether a joint drifts.
        warnings: What limits the comparison, one sentence each.
    """

    robot: str
    sessions: tuple[Session, ...]
    compared: tuple[int, ...]
    reference: tuple[int, ...]
    left_out: tuple[tuple[int, str], ...]
    joints: tuple[JointDrift, ...]
    ordered_by: str
    autocorrelation: float
    drift: bool
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class DriftReport:
    """All arms of a batch."""

    arms: tuple[ArmDrift, ...]

    @property
    def drift(self) -> bool:
        """Whether an arm drifts."""
        return any(arm.drift for arm in self.arms)
