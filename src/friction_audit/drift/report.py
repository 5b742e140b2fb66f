"""DriftReport: what changed between sessions, when, and how sure we are."""

from dataclasses import dataclass

from friction_audit.drift.session import Session
from friction_audit.friction.history import Coefficient


@dataclass(frozen=True, kw_only=True, slots=True)
class ChangePoint:
    """A step between two sessions.

    Attributes:
        session: Index, among the sessions that were compared, of the first one after the step.
        low: First index at which the step may lie, 95 % interval.
        high: Last one.
        before: Level before it, with interval.
        after: Level after it.
        relative: Change over the level before it, with interval.
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
        session: Index among the sessions that were compared.
        relative: Deviation from the reference's level, over that level, with its prediction interval.
        outside: Whether it lies outside of the limits (family-wise over the sessions).
    """

    session: int
    relative: Coefficient
    outside: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class CoefficientDrift:
    """One coefficient of one joint over the sessions.

    Attributes:
        coefficient: ``"coulomb_nm"`` or ``"viscous_nms_per_rad"``.
        sessions: Indices into ``ArmDrift.sessions`` of those that were compared.
        values: The coefficient in each of them, as compared (at like temperature), with interval.
        temperature_slope: Relative change per degree that was taken out, NaN where none could be.
        trend_per_session: Robust slope, unit of the coefficient per session.
        trend_per_day: The same per day; NaN where starts are not known.
        trend_p_value: Family-wise.
        change_points: Steps, in order.
        control: Every session against the reference.
        total: Relative change from the reference (or the first sessions) to the last ones, with interval.
        scatter: Relative standard deviation between sessions beyond the intervals of the estimates.
        smallest_drift: Relative change, start to end, that so many sessions would have shown with 90 % power.
        drift: Whether there is any.
        message: One sentence.
    """

    coefficient: str
    sessions: tuple[int, ...]
    values: tuple[Coefficient, ...]
    temperature_slope: Coefficient
    trend_per_session: Coefficient
    trend_per_day: Coefficient
    trend_p_value: float
    change_points: tuple[ChangePoint, ...]
    control: tuple[ControlPoint, ...]
    total: Coefficient
    scatter: float
    smallest_drift: float
    drift: bool
    message: str


@dataclass(frozen=True, kw_only=True, slots=True)
class JointDrift:
    """One joint over the sessions.

    Attributes:
        joint: Number for people.
        name: Its name.
        coefficients: What became of each coefficient.
        drift: Whether one of them drifts.
        message: One sentence.
    """

    joint: int
    name: str
    coefficients: tuple[CoefficientDrift, ...]
    drift: bool
    message: str


@dataclass(frozen=True, kw_only=True, slots=True)
class ArmDrift:
    """One arm.

    Attributes:
        robot: Which arm.
        sessions: Its sessions in the order of their starts.
        reference: Indices of the sessions of the reference.
        left_out: Index of each session that was not compared, with the reason.
        joints: What became of each joint.
        warnings: What limits the comparison, one sentence each.
    """

    robot: str
    sessions: tuple[Session, ...]
    reference: tuple[int, ...]
    left_out: tuple[tuple[int, str], ...]
    joints: tuple[JointDrift, ...]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class DriftReport:
    """All arms of a batch."""

    arms: tuple[ArmDrift, ...]
