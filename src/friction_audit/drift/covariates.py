"""Which sessions may be compared: the largest group recorded and read alike."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.session import Order, Series, Session
from friction_audit.joint_log import Float
from friction_audit.joint_numbers import write_joint_numbers

RATE_RATIO = 2.0
"""Rates further apart than that filter noise differently."""

LIKE: tuple[tuple[str, Callable[[Session], object]], ...] = (
    ("drive", lambda session: session.conditions.drive),
    ("torque", lambda session: session.conditions.torque),
    ("gravity", lambda session: session.conditions.gravity),
    ("inertia", lambda session: session.conditions.inertia),
    ("payload", lambda session: session.conditions.payload or "none given"),
    ("joints", lambda session: tuple(joint.joint for joint in session.joints)),
)
"""What must be the same, by its name for people."""

Key = tuple[object, ...]
LeftOut = tuple[tuple[int, str], ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Comparable:
    """Which sessions are compared.

    Attributes:
        compared: Their indices.
        left_out: Index of each other one, with the reason.
        warnings: What limits the comparison.
    """

    compared: tuple[int, ...]
    left_out: LeftOut
    warnings: tuple[str, ...]


def choose_comparable(order: Order) -> Comparable:
    """Choose the largest group of sessions that are alike, the latest one of equal groups."""
    out = dict(order.left_out)
    out |= repeated(order.sessions, skip=out)
    out |= unlike(order.sessions, skip=out)
    out |= other_rate(order.sessions, skip=out)
    compared = tuple(i for i in range(len(order.sessions)) if i not in out)
    return Comparable(
        compared=compared,
        left_out=tuple(sorted(out.items())),
        warnings=(*order_warnings(order), *speed_warnings([order.sessions[i] for i in compared])),
    )


def repeated(sessions: Sequence[Session], *, skip: Iterable[int]) -> dict[int, str]:
    """Find recordings that are there twice: the same content, or the same start and the same estimates."""
    first: dict[Key, int] = {}
    twice: dict[int, str] = {}
    skipped = set(skip)
    for i, session in enumerate(sessions):
        if i in skipped:
            continue
        keys = [("content", session.sha256), *_same_estimates(session)]
        earlier = next((first[key] for key in keys if key in first), None)
        if earlier is not None:
            twice[i] = f"the same recording as {sessions[earlier].path}"
        for key in keys:
            first.setdefault(key, i if earlier is None else earlier)
    return twice


def _same_estimates(session: Session) -> list[Key]:
    """Return what two formats of one recording share, or nothing where that is not enough to tell."""
    values = tuple(float(f"{c.value:.4g}") for joint in session.joints for c in joint.coefficients.values())
    known = tuple(value for value in values if math.isfinite(value))
    if session.start_s is None or not known:
        return []
    return [("estimates", round(session.start_s, 3), known)]


def unlike(sessions: Sequence[Session], *, skip: Iterable[int]) -> dict[int, str]:
    """Find the sessions outside of the largest group that is alike."""
    skipped = set(skip)
    keys = {i: tuple(of(s) for _, of in LIKE) for i, s in enumerate(sessions) if i not in skipped}
    if not keys:
        return {}
    latest = {key: i for i, key in keys.items()}
    group = max(Counter(keys.values()).items(), key=lambda item: (item[1], latest[item[0]]))[0]
    return {i: _difference(key, group) for i, key in keys.items() if key != group}


def _difference(key: Key, group: Key) -> str:
    pairs = zip(LIKE, key, group, strict=True)
    return "; ".join(
        f"{name} {_word(mine)}, of the others {_word(theirs)}" for (name, _), mine, theirs in pairs if mine != theirs
    )


def _word(value: object) -> str:
    return write_joint_numbers(value) if isinstance(value, tuple) else str(value)


def other_rate(sessions: Sequence[Session], *, skip: Iterable[int]) -> dict[int, str]:
    """Find the sessions with a sampling rate far from the usual one."""
    skipped = set(skip)
    rates = {i: session.conditions.rate_hz for i, session in enumerate(sessions) if i not in skipped}
    if not rates:
        return {}
    usual = float(np.median(list(rates.values())))
    far = {i: rate for i, rate in rates.items() if not usual / RATE_RATIO <= rate <= usual * RATE_RATIO}
    return {i: f"{rate:.4g} samples a second, of the others {usual:.4g}" for i, rate in far.items()}


def order_warnings(order: Order) -> list[str]:
    """Tell that the order rests on names."""
    if order.by == "start" or len(order.sessions) == 1:
        return []
    return ["nothing tells when most sessions were recorded: they are in the order of their names"]


def speed_warnings(sessions: Sequence[Session]) -> list[str]:
    """Tell of joints that some sessions moved at speeds that the usual one does not reach."""
    warnings = []
    for number in sorted({joint.joint for session in sessions for joint in session.joints}):
        ranges = [joint.speed_rad_s for session in sessions for joint in session.joints if joint.joint == number]
        table = np.array([speeds for speeds in ranges if np.all(np.isfinite(speeds))])
        if not len(table):
            continue
        low, _, high = np.median(table, axis=0)
        apart = int(np.count_nonzero((table[:, 0] > high) | (table[:, 2] < low)))
        if apart:
            warnings.append(
                f"joint {number}: {apart} of {len(table)} sessions move at other speeds than the usual "
                f"{low:.2g} to {high:.2g} rad/s; viscous friction is then an extrapolation"
            )
    return warnings


LEAST_RANGE_K = 2.0
"""Temperatures that vary less are alike."""

FEWEST = 6
"""With fewer sessions a slope over the temperature leaves nothing for the drift."""

ENOUGH_KNOWN = 0.75
"""Share of the sessions that know their temperature; the others are then set aside."""

TOGETHER = 0.8
"""Share of a drift's shape that the temperature follows too: beyond it nobody can tell which of the two it is."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LikeTemperature:
    """A series with what can be done about its temperature.

    Attributes:
        series: Without the sessions that cannot be compared; its temperature is None where it is not taken out.
        unknown: Sessions set aside, indices into all sessions of the arm.
        warning: What limits the comparison; empty if nothing.
    """

    series: Series
    unknown: tuple[int, ...] = ()
    warning: str = ""


def use_temperature(series: Series) -> LikeTemperature:
    """Decide whether a temperature is taken out of a series."""
    if series.temperature is None or not len(series.value):
        return LikeTemperature(series=replace(series, temperature=None))
    known = np.isfinite(series.temperature)
    if not np.any(known):
        return LikeTemperature(
            series=replace(series, temperature=None),
            warning="temperature is not known: not compared at like temperature",
        )
    count, all_of_them = int(np.count_nonzero(known)), len(known)
    if count < ENOUGH_KNOWN * all_of_them or count < FEWEST:
        why = f"temperature is known in {count} of {all_of_them} sessions only: not compared at like temperature"
        if count == all_of_them:
            why = f"{count} sessions with a temperature, {FEWEST} are needed: not compared at like temperature"
        return LikeTemperature(series=replace(series, temperature=None), warning=why)
    kept = series.take(known)
    unknown = tuple(int(index) for index in series.session[~known])
    return LikeTemperature(series=kept if _varies(kept) else replace(kept, temperature=None), unknown=unknown)


def _varies(series: Series) -> bool:
    counted = series.counted().temperature
    if counted is None or len(counted) < FEWEST:
        return False
    return float(np.ptp(counted)) >= LEAST_RANGE_K


def without_temperature(series: Series) -> Series:
    """Return the series as if no temperature were known."""
    return replace(series, temperature=None)


def shared(shape: Float, other: Float) -> float:
    """Return the share of a shape that a straight line over the other one follows (squared correlation)."""
    if np.ptp(other) == 0.0 or np.ptp(shape) == 0.0:
        return 0.0
    return float(np.corrcoef(shape, other)[0, 1] ** 2)


def counts(series: Series, isolated: NDArray[np.bool_]) -> Series:
    """Return the series with the isolated sessions set aside."""
    return replace(series, kept=~isolated)
