"""Recordings before and after -> the change of each joint's friction: coefficients, friction law, conditions."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr, stdtrit

from friction_audit.drift.covariates import Condition, differences, known_by
from friction_audit.drift.regression import holm, random_effects, relative_change
from friction_audit.drift.report import ArmDrift, CoefficientDrift, DriftSettings, JointDrift
from friction_audit.drift.session import COEFFICIENTS, JointSummary, Session, SpeedCurve, restore_joints
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.friction.history import NAN, UNDETERMINED, Coefficient
from friction_audit.friction.weighted import CONFIDENCE
from friction_audit.joint_log import Float
from friction_audit.joint_numbers import write_joint_numbers
from friction_audit.preprocessing.interaction import Reason

SETTINGS = DriftSettings()  # the level of the tests and the power of the smallest change, as in a batch
UNITS = dict(zip(COEFFICIENTS, ((1.0, 0.0), (0.0, 1.0)), strict=True))  # combinations that are one coefficient alone
TWO_SIDED = 0.5 + CONFIDENCE / 2  # probability below the upper end of an interval
SPEEDS = 25  # points of the friction law
TOP_SPEED_RAD_S = 1.0  # of the law where no side has a curve: that of a hand


@dataclass(frozen=True, kw_only=True, slots=True)
class CoefficientChange:
    """One coefficient of one joint on both sides."""

    before: Coefficient  # with its 95 % interval; of several recordings their random-effects mean
    after: Coefficient  # likewise
    freedom: float  # degrees of freedom of the difference (Welch-Satterthwaite)
    single_p_value: float  # of this test alone; that of ``found`` is adjusted over all joints and coefficients (Holm)
    found: CoefficientDrift  # the reference is the side before


class LawChange(NamedTuple):
    """Coulomb plus viscous friction after less before, with its 95 % interval at each speed, shape (m,) each."""

    speed_rad_s: Float
    change_nm: Float
    low_nm: Float
    high_nm: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointChange:
    """One joint that both sides have: its coefficients, its law (None without a covariance), its mean curves."""

    joint: int
    name: str
    coefficients: tuple[CoefficientChange, ...]
    law: LawChange | None
    curves: tuple[tuple[SpeedCurve, ...], ...]  # of the side before, and after
    reason: Reason = ()


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TwoSides:
    """What changed from one side to the other."""

    before: tuple[Session, ...]  # recordings of the first side
    after: tuple[Session, ...]  # of the second side
    joints: tuple[JointChange, ...]  # joints that both sides have
    one_sided: tuple[tuple[int, bool], ...]  # number of each other joint, and whether it is on the first side
    conditions: tuple[Condition, ...]  # what differs
    twice: tuple[str, ...]  # paths of recordings that are on both sides
    unit: str  # of the torque

    @property
    def arms(self) -> tuple[ArmDrift]:
        """The same as the drift of one arm, for limits that hold for both."""
        robot = ", ".join(dict.fromkeys(one.robot or one.path for one in self.after))
        joints = tuple(
            JointDrift(joint=one.joint, name=one.name, coefficients=tuple(change.found for change in one.coefficients))
            for one in self.joints
        )
        return (ArmDrift(robot=robot, joints=joints),)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Mean:
    """A value of some recordings."""

    value: float
    variance: float
    freedom: float  # of the variance
    between: float = NAN  # variance between recordings in it
    scatter: float = NAN  # variance of the values of the recordings, within and between them
    recordings: int = 1
    borrowed: bool = False  # whether a single recording has the variance between those of the other side

    def interval(self) -> Coefficient:
        half = float(stdtrit(self.freedom, TWO_SIDED)) * self.variance**0.5
        return Coefficient.around(self.value, half)


_Sides = Sequence[Sequence[JointSummary]]  # a joint in the recordings of each side that have it


def compare_sides(before: Sequence[Session], after: Sequence[Session]) -> TwoSides:
    """Compare the friction of every joint that both sides have."""
    restored = restore_joints([*before, *after])
    _check_alike(restored)
    sides = before, after = restored[: len(before)], restored[len(before) :]
    numbers = [{joint.joint for one in side for joint in one.joints} for side in sides]
    own = {
        number: [[joint for one in side for joint in one.joints if joint.joint == number] for side in sides]
        for number in sorted(numbers[0] & numbers[1])
    }
    changes = _tested({(n, name): _sides(own[n], parts) for n in own for name, parts in UNITS.items()})
    joints = [
        JointChange(
            joint=number,
            name=both[0][0].name,
            coefficients=tuple(changes[number, name] for name in UNITS),
            law=_law(both),
            curves=tuple(tuple(found.curve for found in side) for side in both),
            reason=tuple(dict.fromkeys(one for side in both for found in side for one in found.reason)),
        )
        for number, both in own.items()
    ]
    if not any(np.isfinite(change.found.change.value) for joint in joints for change in joint.coefficients):
        found = ({joint.joint for one in side for joint in one.joints if not joint.reason} for side in sides)
        first, second = (write_joint_numbers(side) or "none" for side in found)
        why = f"no joint has an estimate on both sides; joints that have one: {first} before, {second} after"
        raise AnalysisError(why, [(joint.joint, joint.reason) for joint in joints if joint.reason])
    content = {key for one in before for key in known_by(one)}
    return TwoSides(
        before=before,
        after=after,
        joints=tuple(joints),
        one_sided=tuple((number, number in numbers[0]) for number in sorted(numbers[0] ^ numbers[1])),
        conditions=tuple(differences(before, after)),
        twice=tuple(one.path for one in after if not content.isdisjoint(known_by(one))),
        unit=before[0].torque_unit,
    )


def _check_alike(recordings: Iterable[Session]) -> None:
    for first, second in pairwise(recordings):
        paths = f"{first.path}, {second.path}"
        if first.torque_unit != second.torque_unit:
            raise UsageError(
                f"{paths}: torque in {first.torque_unit} and in {second.torque_unit}; expected one unit; multiply a "
                "motor current by torque constant and gear ratio"
            )
        if first.log_joints != second.log_joints:
            raise UsageError(
                f"{paths}: {first.log_joints} and {second.log_joints} joints; expected recordings of one arm"
            )


def _sides(own: _Sides, parts: tuple[float, float]) -> tuple[_Mean, _Mean]:
    """Return the mean of a combination on each side; one recording takes the variance between those of the other."""
    first, second = (_random_effects([_combined(one, parts) for one in side]) for side in own)
    return _with_between(first, second), _with_between(second, first)


def _combined(joint: JointSummary, parts: tuple[float, float]) -> _Mean:
    """Return a combination of the two coefficients of a joint, with the covariance of their errors."""
    freedom = max(joint.cycles - 1, 1)  # of the jackknife over cycles
    some = [(part, joint.coefficients[name]) for part, name in zip(parts, COEFFICIENTS, strict=True) if part]
    # An interval that covers a second method is not symmetric: its longer side counts.
    quantile = float(stdtrit(freedom, TWO_SIDED))
    errors = [part * max(one.high - one.value, one.value - one.low) / quantile for part, one in some]
    variance = sum(error**2 for error in errors)
    if all(parts):
        variance += 2.0 * (NAN if joint.correlation is None else joint.correlation) * errors[0] * errors[1]
    return _Mean(value=sum(part * one.value for part, one in some), variance=variance, freedom=freedom)


def _random_effects(found: Sequence[_Mean]) -> _Mean:
    known = [one for one in found if np.isfinite(one.value)]
    if len(known) <= 1:
        return known[0] if known else _Mean(value=NAN, variance=NAN, freedom=NAN, recordings=0)
    values, variances = (np.array([getattr(one, name) for one in known]) for name in ("value", "variance"))
    count, scatter = len(known), float(values.var(ddof=1))
    value, variance, between = float(values.mean()), scatter / count, scatter
    if np.all(np.isfinite(variances) & (variances > 0.0)):  # else estimates without intervals: their scatter alone
        value, variance, between = random_effects(values, variances)
    return _Mean(value=value, variance=variance, freedom=count - 1, between=between, scatter=scatter, recordings=count)


def _with_between(one: _Mean, other: _Mean) -> _Mean:
    """Return a single recording as one of the population of the other side's.

    The variance between few recordings is often estimated as zero; then that of their values counts, as in the
    prediction interval for one more of them.
    """
    if one.recordings != 1 or other.recordings < 2:  # noqa: PLR2004 - several
        return one
    variance = max(one.variance + other.between, other.scatter)
    between = variance - one.variance
    freedom = _satterthwaite((one.variance, one.freedom), (between, other.freedom))
    return replace(one, variance=variance, freedom=freedom, borrowed=between > 0.0)


def _satterthwaite(*parts: tuple[float, float]) -> float:
    """Return the degrees of freedom of a sum of variances (B. L. Welch, Biometrika 34, 1947)."""
    total = sum(variance for variance, _ in parts)
    below = sum(variance**2 / freedom for variance, freedom in parts)
    return float(total**2 / below) if below > 0.0 else min(freedom for _, freedom in parts)


def _difference(first: _Mean, second: _Mean) -> _Mean:
    freedom = _satterthwaite((first.variance, first.freedom), (second.variance, second.freedom))
    if first.borrowed or second.borrowed:  # one variance between recordings stands in both
        freedom = min(first.freedom, second.freedom)
    return _Mean(value=second.value - first.value, variance=first.variance + second.variance, freedom=freedom)


def _tested(every: Mapping[tuple[int, str], tuple[_Mean, _Mean]]) -> dict[tuple[int, str], CoefficientChange]:
    """Test each coefficient by Welch's t test, adjusted over all joints and coefficients (Holm)."""
    p_values = {key: _p_value(_difference(*sides)) for key, sides in every.items()}
    known = {key: p for key, p in p_values.items() if np.isfinite(p)}
    adjusted = dict(zip(known, holm([*known.values()]) if known else (), strict=True))
    level = 1.0 - SETTINGS.alpha / max(len(known), 1)
    return {key: _change(key[1], sides, p_values[key], adjusted.get(key, NAN), level) for key, sides in every.items()}


def _p_value(change: _Mean) -> float:
    if not np.isfinite(change.variance):
        return NAN
    score = abs(change.value) / change.variance**0.5 if change.variance > 0.0 else np.inf * abs(change.value)
    return float(2.0 * stdtr(change.freedom, -score)) if change.value else 1.0


def _change(name: str, sides: tuple[_Mean, _Mean], single: float, p_value: float, level: float) -> CoefficientChange:
    first, second = sides
    change, total = _difference(first, second), UNDETERMINED
    ends = [replace(one, freedom=change.freedom).interval() for one in sides]
    if first.value > 0.0 and not ends[0].low <= 0.0:  # of an estimate without an interval the ratio is known
        total = relative_change(*ends)
    quantiles = stdtrit(change.freedom, 0.5 + level / 2) + stdtrit(change.freedom, SETTINGS.power)
    smallest = float(quantiles) * change.variance**0.5
    found = CoefficientDrift(
        coefficient=name,
        sessions=tuple(range(sum(one.recordings for one in sides if np.isfinite(one.value)))),
        values=(),
        level=first.interval(),
        shape="none" if np.isfinite(single) else "too_few",
        p_value=p_value,
        change=change.interval(),
        total=total,
        smallest_change=smallest,
        smallest_drift=smallest / first.value if np.isfinite(total.value) else NAN,
        drift=p_value <= SETTINGS.alpha,
    )
    return CoefficientChange(
        before=first.interval(), after=second.interval(), freedom=change.freedom, single_p_value=single, found=found
    )


def _law(own: _Sides) -> LawChange | None:
    """Return the change of Coulomb plus viscous friction over the speeds that both sides reach."""
    reached = [[abs(speed) for found in side for speed in found.curve.speed_rad_s] for side in own]
    top = min((max(side) for side in reached if side), default=TOP_SPEED_RAD_S)
    speeds = np.linspace(top / SPEEDS, top, SPEEDS)
    found = [_difference(*_sides(own, (1.0, float(speed)))).interval() for speed in speeds]
    table = np.array([(one.value, one.low, one.high) for one in found]).T
    return LawChange(speeds, *table) if np.isfinite(table).all() else None
