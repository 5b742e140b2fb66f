"""Limits of a joint's motion, and candidate motions within them: short excursions from rest to rest at the start."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from friction_audit.errors import UsageError
from friction_audit.planning.task import Joint
from friction_audit.presets import PRESETS
from friction_audit.robot.arm import read_urdf
from friction_audit.robot.urdf import limits_in
from friction_audit.simulation.strokes import PEAK, Stroke

# Where the highest acceleration is published, a quarter of it, with this jerk: as joint_limits.yaml of
# panda_moveit_config (moveit_resources) does for the Panda.
ACCELERATION_SHARE, JERK_RAD_S3 = 0.25, 300.0
USUAL = (1.5, 2.5, 100.0)  # rad/s, rad/s^2, rad/s^3: below the limits of all common arms
HAND = (1.8, 8.0, 150.0)  # what a person does with ease; slower than this a person is not steady:
HAND_SLOWEST, ROBOT_SLOWEST = 0.05, 0.01  # rad/s
MARGIN_RAD = 0.05  # kept from the ends of the joint's range
LEAST_RANGE_RAD = 0.02  # below it no candidate motion has a certain direction for long


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of one joint."""

    start_rad: float  # where the motion starts and ends
    low_rad: float
    high_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    jerk_rad_s3: float
    slowest_rad_s: float  # slowest steady speed
    source: str  # where they come from

    def __post_init__(self) -> None:
        if not self.low_rad <= self.start_rad <= self.high_rad:
            where = f"outside of {self.low_rad:.3g} to {self.high_rad:.3g} rad, where the joint may move"
            raise UsageError(f"start {self.start_rad:.3g} rad: {where}; give another --start, or --range")
        if (width := self.high_rad - self.low_rad) < LEAST_RANGE_RAD:
            raise UsageError(f"{width:.3g} rad of range: expected at least {LEAST_RANGE_RAD:g}; widen --range")
        rates, least = (self.speed_rad_s, self.acceleration_rad_s2, self.jerk_rad_s3), 2.0 * self.slowest_rad_s
        if not all(0.0 < rate < inf for rate in rates) or self.speed_rad_s < least:
            found = f"limits of {rates[0]:g} rad/s, {rates[1]:g} rad/s^2 and {rates[2]:g} rad/s^3"
            expected = f"expected a speed of at least {least:g} rad/s, and others above zero"
            raise UsageError(f"{found}: {expected}; raise --speed, --acceleration or --jerk")


def limits_of(
    joint: Joint,
    start_rad: float,
    *,
    urdf: Path | None,
    robot: str = "",
    range_rad: tuple[float, ...] | None = None,
    **asked: float | None,
) -> Limits:
    """Return the limits of a joint: those of the arm, tightened to those of a hand, replaced by what is asked for.

    The range is relative to the start; what is asked for has the names of ``Limits``, None where the arm decides.
    """
    low, high, speed = -inf, inf, inf
    acceleration, jerk, source = (*USUAL[1:], "usual of arms")
    if urdf is not None:
        low, high, speed = limits_in(read_urdf(urdf), str(urdf), joint.name)
        source = f"{urdf.name}; acceleration and jerk {source}"
    elif robot in PRESETS and joint.number <= len(PRESETS[robot].joints):
        preset, k = PRESETS[robot], joint.number - 1
        low, high, speed = preset.low_rad[k], preset.high_rad[k], preset.speed_rad_s[k]
        if preset.acceleration_rad_s2:
            acceleration, jerk = ACCELERATION_SHARE * preset.acceleration_rad_s2[k], JERK_RAD_S3
            source = f"{preset.source}; a quarter of the acceleration, jerk of panda_moveit_config"
        else:
            source = f"{preset.source}; acceleration and jerk {source}"
    if joint.hand:
        speed, acceleration, jerk = map(min, (speed, acceleration, jerk), HAND)
        source = f"{source}; at most those of a person"
    below, above = range_rad or joint.reach_rad
    found = Limits(
        start_rad=start_rad,
        low_rad=max(low + MARGIN_RAD, start_rad + below),
        high_rad=min(high - MARGIN_RAD, start_rad + above),
        speed_rad_s=USUAL[0] if speed == inf else speed,
        acceleration_rad_s2=acceleration,
        jerk_rad_s3=jerk,
        slowest_rad_s=HAND_SLOWEST if joint.hand else ROBOT_SLOWEST,
        source=source,
    )
    given: dict[str, Any] = {key: value for key, value in asked.items() if value is not None}
    return replace(found, **given)


BEND = 10.0 / np.sqrt(3.0)  # largest change of the slope of the velocity's course (``motion.course``)
REST_S = 0.4  # after an excursion: its cycles end there
LONGEST_S = 3.0  # of a slow ramp one way: slower ones go less far
# What it is, places to go to, speeds, rest after each stroke, and whether strokes have no constant speed.
Excursion = tuple[str, Sequence[float], ArrayLike, float, bool]
ROUNDING_RAD = 1e-6  # of a side without room
SHARP_S = 0.15  # a person or a motor without overshoot takes at least so long to reach a speed


@dataclass(frozen=True, slots=True)
class Candidate:
    """An excursion: what it is, in words, and its strokes."""

    words: str
    strokes: tuple[Stroke, ...]

    @property
    def duration_s(self) -> float:
        """Its length with the rests. [s]"""
        return sum(one.duration_s for one in self.strokes)

    @property
    def span_rad(self) -> tuple[float, float]:
        """Lowest and highest position relative to the start. [rad]"""
        places = np.cumsum([0.0, *(one.way_rad for one in self.strokes)])
        return float(places.min()), float(places.max())


def candidates_of(limits: Limits) -> list[Candidate]:
    """Return the candidate excursions."""
    low, high = limits.low_rad - limits.start_rad, limits.high_rad - limits.start_rad
    fast, slowest = _stroke(high - low, np.inf, limits).speed_rad_s, limits.slowest_rad_s
    if fast < 4.0 * slowest:
        found = f"the fastest motion over {high - low:.3g} rad has {fast:.2g} rad/s; expected at least {4 * slowest:g}"
        raise UsageError(f"limits: {found}; widen --range or raise --speed, --acceleration or --jerk")
    candidates = []
    for words, places, speeds, rest_s, smooth in _excursions(low, high, fast, limits):
        ways = np.diff([0.0, *np.clip(places, low, high)])
        pairs = zip(ways.tolist(), np.broadcast_to(np.asarray(speeds, float), ways.shape).tolist(), strict=True)
        strokes = [_stroke(*one, limits, rest_s=rest_s, smooth=smooth) for one in pairs if abs(one[0]) > ROUNDING_RAD]
        strokes[-1] = strokes[-1]._replace(rest_s=max(REST_S, rest_s))
        candidates.append(Candidate(words, tuple(strokes)))
    return candidates


def _excursions(low: float, high: float, fast: float, limits: Limits) -> Iterator[Excursion]:
    slowest, inner = limits.slowest_rad_s, max(min(-low, high), 0.02)  # half a width that fits on the wider side
    for speed in np.geomspace(slowest, fast, 7):
        up, down = (float(np.clip(end, -speed * LONGEST_S, speed * LONGEST_S)) for end in (high, low))
        words = f"steady at {speed:.2g} rad/s, there and back to both sides"
        yield words, [up, 0.0, down, 0.0], speed, 0.3, False
    ends = [high, low, high, low, 0.0]
    for speed in (0.25 * fast, 0.5 * fast, fast):
        yield f"swing from end to end without rest, peak {speed:.2g} rad/s", ends, speed, 0.0, True
    for reach, share in product((0.1, 0.3), (0.4, 1.0)):
        place = reach * (high - low) / 2.0
        speed = share * _stroke(2.0 * place, np.inf, limits).speed_rad_s
        places = [*(min(place, inner) * (-1) ** np.arange(10)), 0.0]
        words = f"10 quick reversals over {2 * abs(places[0]):.2g} rad, peak {speed:.2g} rad/s"
        yield words, places, speed, 0.0, True
    places = [*np.linspace(0.0, high, 4)[1:], *np.linspace(high, low, 7)[1:], *np.linspace(low, 0.0, 4)[1:]]
    speed = max(0.15 * fast, 2.0 * slowest)
    for rest_s in (0.15, 0.6, 2.0):
        words = f"12 steps through the range with rests of {rest_s:g} s, peak {speed:.2g} rad/s"
        yield words, places, speed, rest_s, True
    for up, down in ((0.15 * fast, 0.8 * fast), (0.8 * fast, 0.15 * fast)):
        words = f"up at {up:.2g} rad/s and down at {down:.2g} rad/s"
        yield words, ends, [up, down, up, down, up], 0.0, False
    ways = np.geomspace(0.02, 0.2, 8) if slowest > 0.02 else np.geomspace(1e-3, 0.03, 12)  # noqa: PLR2004 - by hand
    ways = ways[ways < min(high - low, 1.0)] / 2.0
    if len(ways) > 2 and -low > ways[-1] < high:  # noqa: PLR2004 - some
        places = [*(ways * (-1.0) ** np.arange(len(ways))), 0.0]
        words = f"{len(ways)} small reversals of growing way, {2 * ways[0]:.2g} to {2 * ways[-1]:.2g} rad"
        yield words, places, 2.0 * np.abs(np.diff([0.0, *np.clip(places, low, high)])), 0.05, True
    sides = np.linspace(0.2, 1.0, 6) * (-1.0) ** np.arange(6)
    places = [*(min(abs(side), inner) * np.sign(side) for side in sides * (high - low) / 2.0), 0.0]
    yield "chirp: swings of growing width and speed", places, np.linspace(0.2, 1.0, 7) * fast, 0.0, True


def _stroke(way: float, speed: float, limits: Limits, *, rest_s: float = 0.0, smooth: bool = False) -> Stroke:
    """Return a stroke at a speed, or as fast as the limits allow; smooth ones have no constant speed."""
    length = abs(way)
    bell = ((limits.acceleration_rad_s2 * length / PEAK) ** 0.5, (limits.jerk_rad_s3 * length**2 / BEND) ** (1 / 3))
    speed = min(speed, limits.speed_rad_s, length / SHARP_S, *bell)
    needed = max(PEAK * speed / limits.acceleration_rad_s2, (BEND * speed / limits.jerk_rad_s3) ** 0.5, SHARP_S)
    return Stroke(way, speed, min(length / speed if smooth else needed, length / speed), rest_s)
