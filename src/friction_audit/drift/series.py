"""Series: one coefficient of one joint over the sessions that are compared."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.session import JointSummary, Session
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

COEFFICIENTS = ("coulomb_nm", "viscous_nms_per_rad")

NORMAL_95 = 1.959964
"""Half of a 95 % interval, in standard errors."""

LARGEST_RELATIVE_ERROR = 0.25
"""Less certain estimates are too skewed for a logarithm."""

SECONDS_A_DAY = 86400.0


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Series:
    """One coefficient of one joint over the sessions, n of which have an estimate.

    Drift is looked for in y: the logarithm of the coefficient where it is positive and certain enough, so that changes
    are relative and warmth, which acts on viscous friction exponentially, is straight; else the coefficient itself.

    Attributes:
        joint: Number for people.
        coefficient: Which one.
        session: Indices into all sessions of the arm, shape (n,).
        place: Places among those compared, from 0, shape (n,).
        day: Days since the first session, shape (n,), or None where starts are not known. [d]
        value: Estimates, shape (n,).
        error: Their standard errors, shape (n,).
        temperature: Of the joint, shape (n,), or None where it cannot be used. [degC]
        speed: Median speed in motion, shape (n,). [rad/s]
        logarithmic: Whether y is the logarithm.
        kept: Which sessions count: False for an isolated one, shape (n,).
    """

    joint: int
    coefficient: str
    session: NDArray[np.int64]
    place: Float
    day: Float | None
    value: Float
    error: Float
    temperature: Float | None
    speed: Float
    logarithmic: bool
    kept: NDArray[np.bool_]

    @property
    def y(self) -> Float:
        """What drift is looked for in, shape (n,)."""
        return np.log(self.value) if self.logarithmic else self.value

    @property
    def y_error(self) -> Float:
        """Standard error of y, shape (n,)."""
        return self.error / self.value if self.logarithmic else self.error

    def take(self, which: NDArray[np.bool_]) -> "Series":
        """Return the series of some of its sessions."""
        return replace(
            self,
            **{name: getattr(self, name)[which] for name in ("session", "place", "value", "error", "speed", "kept")},
            day=None if self.day is None else self.day[which],
            temperature=None if self.temperature is None else self.temperature[which],
        )

    def counted(self) -> "Series":
        """Return the series of the sessions that count."""
        return self.take(self.kept)


def make_series(
    sessions: Sequence[Session], compared: Sequence[int], joint: int, coefficient: str, *, by_start: bool
) -> Series:
    """Collect one coefficient of one joint (by number) over the sessions that are compared."""
    rows = []
    for place_among, i in enumerate(compared):
        summary = next((each for each in sessions[i].joints if each.joint == joint), None)
        found = summary.coefficients.get(coefficient, UNDETERMINED) if summary is not None else UNDETERMINED
        if summary is not None and np.isfinite(found.value):
            rows.append((i, place_among, *_numbers(sessions[i], summary, found)))
    table = np.array(rows, dtype=float).reshape(-1, 7)
    index, place, start, value, error, temperature, speed = table.T
    error = _fill(error, value)
    return Series(
        joint=joint,
        coefficient=coefficient,
        session=index.astype(np.int64),
        place=place,
        day=(start - np.min(start, initial=np.inf)) / SECONDS_A_DAY if by_start else None,
        value=value,
        error=error,
        temperature=temperature,
        speed=speed,
        logarithmic=is_logarithmic(value, error),
        kept=np.ones(len(value), dtype=np.bool_),
    )


def _numbers(session: Session, summary: JointSummary, found: Coefficient) -> tuple[float, ...]:
    start = np.nan if session.start_s is None else session.start_s
    warmth = session.temperature_c if summary.temperature_c is None else summary.temperature_c
    error = (found.high - found.low) / (2 * NORMAL_95)
    return start, found.value, error, np.nan if warmth is None else warmth, summary.speed_rad_s[1]


def _fill(error: Float, value: Float) -> Float:
    """Give estimates without an interval the largest error of the others; a relative one of 1e-9 keeps it off 0."""
    known = error[np.isfinite(error)]
    filled = np.where(np.isfinite(error), error, np.max(known, initial=0.0))
    return np.maximum(filled, 1e-9 * max(float(np.max(np.abs(value), initial=0.0)), 1e-9))


def is_logarithmic(value: Float, error: Float) -> bool:
    """Return whether all estimates are positive and most are certain enough for a logarithm."""
    if not len(value) or np.min(value) <= 0.0:
        return False
    return bool(np.median(error / value) <= LARGEST_RELATIVE_ERROR)
