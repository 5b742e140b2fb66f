"""Candidate motions: short excursions from rest at the start to rest at the start, within the limits of a joint."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.planning.limits import Limits
from friction_audit.simulation.motion.prescribed import Stroke

# Largest slope of the velocity's course, of length and height 1, and largest change of the slope (``motion.course``).
SLOPE, BEND = 1.875, 10.0 / np.sqrt(3.0)
REST_S = 0.4  # after an excursion: its cycles end there
LONGEST_S = 3.0  # of a slow ramp one way: slower ones go less far
SHARP_S = 0.15  # a person or a motor without overshoot takes at least so long to reach a speed


@dataclass(frozen=True, slots=True)
class Candidate:
    """An excursion: what it is, in words, and its strokes."""

    words: str
    strokes: tuple[Stroke, ...]

    @property
    def duration_s(self) -> float:
        """Its length with the rests. [s]"""
        return sum(one.moving_s + one.rest_s for one in self.strokes)

    @property
    def span_rad(self) -> tuple[float, float]:
        """Lowest and highest position relative to the start. [rad]"""
        places = np.cumsum([0.0, *(one.way_rad for one in self.strokes)])
        return float(places.min()), float(places.max())


def candidates_of(limits: Limits) -> tuple[Candidate, ...]:
    """Return the candidate excursions.

    Raises:
        UsageError: If the limits leave hardly any speed.
    """
    low, high = limits.low_rad - limits.start_rad, limits.high_rad - limits.start_rad
    fast = _stroke(high - low, np.inf, limits).speed_rad_s
    if fast < 4.0 * limits.slowest_rad_s:
        raise UsageError(
            f"limits: the fastest motion over {high - low:.3g} rad has {fast:.2g} rad/s; expected at least "
            f"{4.0 * limits.slowest_rad_s:g}; widen --range or raise --speed, --acceleration or --jerk"
        )
    return tuple(_excursions(low, high, fast, limits))


def _excursions(low: float, high: float, fast: float, limits: Limits) -> Iterator[Candidate]:
    hand = limits.slowest_rad_s > 0.02  # noqa: PLR2004 - rad/s: slower than a person is steady
    for speed in np.geomspace(limits.slowest_rad_s, fast, 7):
        ends = [float(np.clip(end, -speed * LONGEST_S, speed * LONGEST_S)) for end in (high, low)]
        yield _of(f"steady at {speed:.2g} rad/s, there and back to both sides", [ends[0], 0.0, ends[1], 0.0],
                  speed, limits, rest_s=0.3)  # fmt: skip
    for share in (0.25, 0.5, 1.0):
        places = [high, low, high, low, 0.0]
        yield _of(f"swing from end to end without rest, peak {share * fast:.2g} rad/s", places, share * fast, limits,
                  smooth=True)  # fmt: skip
    for reach in (0.1, 0.3):
        for share in (0.4, 1.0):
            place = reach * (high - low) / 2.0
            speed = share * _stroke(2.0 * place, np.inf, limits).speed_rad_s
            places = [*(_middle(low, high, place) * (-1) ** np.arange(10)), 0.0]
            words = f"10 quick reversals over {2 * abs(places[0]):.2g} rad, peak {speed:.2g} rad/s"
            yield _of(words, places, speed, limits, smooth=True)
    for rest_s in (0.15, 0.6, 2.0):
        steps = [*np.linspace(0.0, high, 4)[1:], *np.linspace(high, low, 7)[1:], *np.linspace(low, 0.0, 4)[1:]]
        slow = max(0.15 * fast, 2.0 * limits.slowest_rad_s)
        yield _of(f"12 steps through the range with rests of {rest_s:g} s, peak {slow:.2g} rad/s", steps, slow,
                  limits, rest_s=rest_s, smooth=True)  # fmt: skip
    for there, back in ((0.15, 0.8), (0.8, 0.15)):
        places = [high, low, high, low, 0.0]
        speeds = [fast * (there if k % 2 == 0 else back) for k in range(5)]
        words = f"up at {speeds[0]:.2g} rad/s and down at {speeds[1]:.2g} rad/s"
        yield _of(words, places, speeds, limits)
    ways = np.geomspace(0.02, 0.2, 8) if hand else np.geomspace(1e-3, 0.03, 12)
    ways = ways[ways < min(high - low, 1.0)] / 2.0
    if len(ways) > 2 and -low > ways[-1] < high:  # noqa: PLR2004 - some
        places = [*(ways * (-1.0) ** np.arange(len(ways))), 0.0]
        yield _of(f"{len(ways)} small reversals of growing way, {2 * ways[0]:.2g} to {2 * ways[-1]:.2g} rad", places,
                  None, limits, rest_s=0.05, smooth=True)  # fmt: skip
    sides = np.linspace(0.2, 1.0, 6) * (-1.0) ** np.arange(6)
    places = [*(_middle(low, high, abs(side)) * np.sign(side) for side in sides * (high - low) / 2.0), 0.0]
    yield _of("chirp: swings of growing width and speed", places, np.linspace(0.2, 1.0, 7) * fast, limits, smooth=True)


def _middle(low: float, high: float, half: float) -> float:
    """Return a half-width that fits on both sides of the start, or half a width on the wider one."""
    return min(half, max(min(-low, high), 0.02))


def _of(
    words: str,
    places: Sequence[float],
    speeds: float | Sequence[float] | Float | None,
    limits: Limits,
    *,
    rest_s: float = 0.0,
    smooth: bool = False,
) -> Candidate:
    low, high = limits.low_rad - limits.start_rad, limits.high_rad - limits.start_rad
    ways = np.diff([0.0, *np.clip(places, low, high)])
    wanted = np.broadcast_to(2.0 * np.abs(ways) if speeds is None else np.asarray(speeds, float), ways.shape)
    strokes = [
        _stroke(float(way), float(speed), limits, rest_s=rest_s, smooth=smooth)
        for way, speed in zip(ways, wanted, strict=True)
        if abs(way) > 1e-6  # noqa: PLR2004 - rounding: a side without room
    ]
    strokes[-1] = strokes[-1]._replace(rest_s=max(REST_S, rest_s))
    return Candidate(words, tuple(strokes))


def _stroke(way: float, speed: float, limits: Limits, *, rest_s: float = 0.0, smooth: bool = False) -> Stroke:
    """Return a stroke at a speed, or as fast as the limits allow; smooth ones have no constant speed."""
    length = abs(way)
    bell = ((limits.acceleration_rad_s2 * length / SLOPE) ** 0.5, (limits.jerk_rad_s3 * length**2 / BEND) ** (1 / 3))
    speed = min(speed, limits.speed_rad_s, length / SHARP_S, *bell)
    needed = max(SLOPE * speed / limits.acceleration_rad_s2, (BEND * speed / limits.jerk_rad_s3) ** 0.5, SHARP_S)
    return Stroke(way, speed, min(length / speed if smooth else needed, length / speed), rest_s)
