"""Covariates: which sessions were recorded alike and may be compared, and what the temperature explains."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from friction_audit.drift.session import Order, Series, Session
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution, Reason

RATE_RATIO = 2.0  # rates further apart filter noise differently
LEAST_RANGE_K = 2.0  # temperatures that vary less are alike
FEWEST = 6  # with fewer sessions a slope over the temperature leaves no degrees of freedom for the drift
ENOUGH_KNOWN = 0.75  # share of the sessions that know their temperature; the others are then set aside
CONFOUNDED = 0.8  # share of a change that the temperature follows too: beyond it the two cannot be separated

INVALID = ("drive", "torque", "gravity", "friction model")  # where these differ, the estimates are of different things

# What must be the same, by its name for people.
LIKE: Mapping[str, Callable[[Session], object]] = {
    **{name: attrgetter(f"conditions.{name}") for name in ("drive", "torque", "gravity", "inertia")},
    "payload": lambda session: session.conditions.payload or "none given",
}


def choose_comparable(order: Order) -> tuple[tuple[int, ...], dict[int, Reason], list[Caution]]:
    """Return the largest group of sessions that are alike, the latest of equal ones; the others; what limits it."""
    sessions, out, warnings = order.sessions, dict(order.left_out), []
    for find in (_repeated, _unlike, _other_rate):
        out |= find({i: session for i, session in enumerate(sessions) if i not in out})
    compared = tuple(i for i in range(len(sessions)) if i not in out)
    if order.by != "start" and len(sessions) > 1:
        warnings.append(Caution("ordered_by_name"))
    warnings += _speed_warnings([sessions[i] for i in compared])
    return compared, dict(sorted(out.items())), warnings


def _repeated(sessions: dict[int, Session]) -> dict[int, Reason]:
    first: dict[tuple[object, ...], int] = {}
    twice: dict[int, Reason] = {}
    for i, session in sessions.items():
        keys = known_by(session)
        earlier = next((first[key] for key in keys if key in first), None)
        if earlier is not None:
            twice[i] = (Caution("recorded_twice", numbers={"path": sessions[earlier].path}),)
        for key in keys:
            first.setdefault(key, i if earlier is None else earlier)
    return twice


def known_by(session: Session) -> list[tuple[object, ...]]:
    """Return by what a recording is known in another file or format: content; estimates with start or duration."""
    keys: list[tuple[object, ...]] = [("content", session.sha256)]
    found = [c.value for joint in session.joints for c in joint.coefficients.values() if math.isfinite(c.value)]
    if found:  # a copy may have lost the start, then by more digits
        keys.append(("duration", round(session.duration_s, 3), *(float(f"{value:.6g}") for value in found)))
    if found and session.start_s is not None:
        keys.append(("start", round(session.start_s, 3), *(float(f"{value:.4g}") for value in found)))
    return keys


def _unlike(sessions: dict[int, Session]) -> dict[int, Reason]:
    """Find the sessions outside of the largest group that is alike."""
    keys = {i: tuple(of(session) for of in LIKE.values()) for i, session in sessions.items()}
    latest, count = {key: i for i, key in keys.items()}, Counter(keys.values())
    group = max(count, key=lambda key: (count[key], latest[key]), default=())
    unlike = {i: zip(LIKE, key, group, strict=True) for i, key in keys.items() if key != group}
    return {
        i: tuple(
            Caution("unlike_session", numbers={"name": name, "case": name, "mine": mine, "theirs": theirs})
            for name, mine, theirs in each
            if mine != theirs
        )
        for i, each in unlike.items()
    }


def _other_rate(sessions: dict[int, Session]) -> dict[int, Reason]:
    """Find the sessions with a sampling rate far from the usual one."""
    rates = {i: session.conditions.rate_hz for i, session in sessions.items()}
    usual = float(np.median(list(rates.values()))) if rates else math.nan
    far = {i: rate for i, rate in rates.items() if not usual / RATE_RATIO <= rate <= usual * RATE_RATIO}
    return {i: (Caution("other_rate", numbers={"rate": rate, "usual": usual}),) for i, rate in far.items()}


def _speed_warnings(sessions: Sequence[Session]) -> list[Caution]:
    """Warn of joints that some sessions moved at speeds that the usual one does not reach."""
    ranges: dict[int, list[tuple[float, float, float]]] = {}
    for joint in (joint for session in sessions for joint in session.joints if np.all(np.isfinite(joint.speed_rad_s))):
        ranges.setdefault(joint.joint, []).append(joint.speed_rad_s)
    warnings = []
    for number, found in sorted(ranges.items()):
        table = np.array(found)
        low, _, high = np.median(table, axis=0)
        if apart := int(np.count_nonzero((table[:, 0] > high) | (table[:, 2] < low))):
            numbers = {"apart": apart, "every": len(table), "low": float(low), "high": float(high)}
            warnings.append(Caution("other_speeds", number, numbers))
    return warnings


def use_temperature(series: Series, sessions: Sequence[Session]) -> tuple[Series, Caution | None]:
    """Return a series, without its temperature where that is not taken out, and what limits the comparison."""
    bare = replace(series, temperature=None)
    if series.temperature is None or not len(series.y):
        return bare, None
    known = np.isfinite(series.temperature)
    count, every = int(np.count_nonzero(known)), len(known)
    if count < ENOUGH_KNOWN * every or count < FEWEST:
        case = "few" if count == every else "some" if count else "none"
        # Where none is known, series of different lengths have one caution.
        numbers = {"case": case, "fewest": FEWEST} | ({"count": count, "every": every} if count else {})
        return bare, Caution("temperature_not_used", numbers=numbers)
    kept = series.take(known)
    counted = kept.take(kept.kept).temperature
    varies = counted is not None and len(counted) >= FEWEST and float(np.ptp(counted)) >= LEAST_RANGE_K
    names = ", ".join(sessions[index].path for index in series.session[~known])
    unknown = Caution("temperature_not_known", numbers={"names": names}) if names else None
    return kept if varies else replace(kept, temperature=None), unknown


def shared(column: Float, other: Float) -> float:
    """Return the share of a change that a straight line over the other one explains (squared correlation)."""
    if np.ptp(other) == 0.0 or np.ptp(column) == 0.0:
        return 0.0
    return float(np.corrcoef(column, other)[0, 1] ** 2)


@dataclass(frozen=True, kw_only=True, slots=True)
class Condition:
    """A condition that differs between the sides, of one joint or of all (None)."""

    name: str
    before: str
    after: str
    joint: int | None = None


def differences(before: Sequence[Session], after: Sequence[Session]) -> Iterator[Condition]:
    """Yield the conditions that differ, those that forbid a comparison first."""
    values = {name: [{str(of(one)) for one in side} for side in (before, after)] for name, of in LIKE.items()}
    values["friction model"] = [{one.method for one in side} for side in (before, after)]
    for name, sides in sorted(values.items(), key=lambda one: one[0] not in INVALID):
        if sides[0] != sides[1]:
            words = [", ".join(sorted(side)) for side in sides]
            yield Condition(name=name, before=words[0], after=words[1])
    rates = [float(np.median([one.conditions.rate_hz for one in side])) for side in (before, after)]
    if not 1.0 / RATE_RATIO <= rates[1] / rates[0] <= RATE_RATIO:
        yield Condition(name="rate", before=f"{rates[0]:.4g} Hz", after=f"{rates[1]:.4g} Hz")
    for number in sorted({joint.joint for one in before for joint in one.joints}):
        yield from _of_joint(number, before, after)


def _of_joint(number: int, before: Sequence[Session], after: Sequence[Session]) -> Iterator[Condition]:
    """Yield speed and temperature of a joint where they differ."""
    own = [[found for one in side for found in one.joints if found.joint == number] for side in (before, after)]
    speeds = [np.array([found.speed_rad_s for found in side if np.isfinite(found.speed_rad_s[1])]) for side in own]
    if all(len(side) for side in speeds):
        (low, _, high), (other_low, _, other_high) = (np.median(side, axis=0) for side in speeds)
        if low > other_high or other_low > high:
            ranges = [f"{a:.2g} to {b:.2g} rad/s" for a, b in ((low, high), (other_low, other_high))]
            yield Condition(name="speed", before=ranges[0], after=ranges[1], joint=number)
    warmth = [[found.temperature_c for found in side if found.temperature_c is not None] for side in own]
    if all(warmth):
        first, second = (float(np.mean(side)) for side in warmth)
        if abs(first - second) >= LEAST_RANGE_K:
            yield Condition(name="temperature", before=f"{first:.1f} °C", after=f"{second:.1f} °C", joint=number)
