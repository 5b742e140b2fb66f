"""Temperature: taken out of the comparison where it is known and varies, jointly with the drift."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.series import Series
from friction_audit.joint_log import Float

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
