"""Strokes of a person or a planner, of a joint or of a hand that guides an arm; minimum-jerk (Flash and Hogan 1985)."""

from collections.abc import Iterator
from itertools import cycle
from math import isfinite
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from friction_audit.compensation.law import FINITE, Checked, positive, within
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float

PEAK = 1.875  # steepest slope of ``min_jerk``, half-way: the peak speed of a stroke of length 1 in time 1
REST_S = 0.5  # rest before the first stroke of a motion and after the last
SHORTEST_S = 0.01  # shortest duration of a stroke


class Reference(NamedTuple):
    """Reference trajectory at the controller's ticks from rest at 0, shape (n + 1,); (n + 1, joints) for several."""

    position: Float  # relative to the start [rad]
    velocity: Float  # its exact derivative [rad/s]


def min_jerk(x: Float) -> tuple[Float, Float]:
    """Return the share of a stroke at the share x of its time, and the derivative; constant outside of [0, 1]."""
    x = np.clip(x, 0.0, 1.0)
    covered = x * x * x * (10.0 + x * (6.0 * x - 15.0))
    return covered, 30.0 * x * x * (1.0 - x) * (1.0 - x)


def area(x: Float) -> Float:
    """Return the integral from 0 to x of ``min_jerk``, which stays 0 below 0 and 1 above 1."""
    inside = np.clip(x, 0.0, 1.0)
    return inside**4 * (2.5 + inside * (inside - 3.0)) + np.maximum(x - 1.0, 0.0)


def segment_at(start_s: Float, t: Float) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    """Return the index of the stroke at every time, the first one before its start; shape of t."""
    return np.maximum(np.searchsorted(start_s, t, side="right") - 1, 0)


def constant_speed_strokes(t: Float, start_s: Float, displacement: Float, speed: Float, ease_s: Float) -> Reference:
    """Return strokes of constant speed with a smooth rise and fall of the velocity; arrays hold one entry each."""
    if not len(start_s):
        return Reference(np.zeros_like(t), np.zeros_like(t))
    stroke = segment_at(start_s, t)
    rise = (t - start_s[stroke]) / ease_s[stroke]
    fall = rise - (np.abs(displacement) / speed / ease_s)[stroke]
    signed, origin = np.copysign(speed, displacement)[stroke], (np.cumsum(displacement) - displacement)[stroke]
    position = origin + signed * ease_s[stroke] * (area(rise) - area(fall))
    return Reference(position, signed * (min_jerk(rise)[0] - min_jerk(fall)[0]))


STRATA = 10  # the speeds of so many strokes in a row are spread evenly over their distribution
TINY = 1e-9  # keeps a rank off 0, whose normal deviate is infinite


class StopAndGo(Checked):
    """Strokes of a person who stops between them."""

    # shortest and longest duration of a stroke; its length follows from the peak speed [s]
    stroke_s: tuple[float, float] = within((0.9, 1.8), SHORTEST_S)
    speed_rad_s: float = positive(0.9)  # mean of the strokes' peak speeds [rad/s]
    speed_spread: float = within(0.4)  # coefficient of variation of the strokes' peak speeds
    speed_limits_rad_s: tuple[float, float] = positive((0.3, 1.8))  # no stroke has a slower or a faster peak [rad/s]
    pause_s: tuple[float, float] = within((0.2, 0.7))  # shortest and longest pause between two strokes [s]
    range_rad: tuple[float, float] = within((-1.2, 1.2), -FINITE)  # lowest and highest position, from the start [rad]
    reversing: float = within(0.8, 0.0, 1.0)  # share of the strokes that turn back, where the range leaves the choice

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        low, high = self.range_rad
        if not low <= 0 <= high or low == high:
            raise UsageError(f"stop_and_go: range_rad {low:g}, {high:g}: expected a range around the start at 0")

    def reference(self, ticks: int, dt: float, rng: np.random.Generator) -> Reference:
        """Return the strokes that fit between two rests at the ticks of the controller; at rest if not one fits."""
        rows, speeds = [(0.0, REST_S, 0.0, 0.0)], list[float]()  # start, duration [s], origin, signed length [rad]
        begin, position, direction = REST_S, 0.0, 1.0
        sigma = np.sqrt(np.log1p(self.speed_spread**2))
        while True:
            if not speeds:  # those of the next strokes: log-normal, stratified, within the limits
                ranks = (rng.permutation(STRATA) + rng.uniform(TINY, 1.0, STRATA)) / STRATA
                deviates = np.array([NormalDist().inv_cdf(rank) for rank in ranks])
                drawn = self.speed_rad_s * np.exp(sigma * deviates - sigma**2 / 2)
                speeds = np.clip(drawn, *self.speed_limits_rad_s).tolist()
            speed = speeds.pop()
            displacement = _draw_length(self, speed, position, direction, rng)
            needed = PEAK * abs(displacement) / speed
            if begin + needed > ticks * dt - REST_S:
                break
            rows.append((begin, needed, position, displacement))
            begin += needed + rng.uniform(*self.pause_s)
            position, direction = position + displacement, float(np.sign(displacement))
        strokes, t = np.array(rows), np.arange(ticks + 1, dtype=np.float64) * dt
        start, lasts, origin, change = strokes[segment_at(strokes[:, 0], t)].T
        covered, slope = min_jerk((t - start) / lasts)
        return Reference(origin + change * covered, change / lasts * slope)


def _draw_length(settings: StopAndGo, speed: float, q: float, direction: float, rng: np.random.Generator) -> float:
    """Draw the signed length of the next stroke; it mostly turns back and always stays in the range."""
    low, high = settings.range_rad
    length = speed * rng.uniform(*settings.stroke_s) / PEAK
    turned = -direction if rng.random() < settings.reversing else direction
    for sign in (turned, -turned):
        if low <= q + sign * length <= high:
            return sign * length
    return (high - q) if high - q > q - low else (low - q)


Target = tuple[float, float]  # a position to go to [rad] and the speed to go with [rad/s]
MOST = 1000  # speeds or small reversals of a pass: more would outlast every recording


class SlowSweep(Checked):
    """Strokes of constant speed to one side and back, at the next speed of a random order to the other and back."""

    speeds_rad_s: tuple[float, float] = positive((0.01, 1.0))  # slowest and fastest speed [rad/s]
    steps: int = within(7, 1, MOST)  # number of speeds in a pass, evenly spaced on a logarithmic scale
    range_rad: tuple[float, float] = within((-0.6, 0.6), -FINITE)  # lowest and highest position, from the start [rad]
    longest_s: float = positive(3.0)  # a stroke turns back after this time although the range goes on [s]
    dwell_s: float = within(0.3)  # rest after every stroke [s]
    ease_s: float = positive(0.2)  # time in which a stroke reaches its speed, and in which it loses it [s]
    reversals: int = within(0, 0, MOST)  # number of small reversals at the start of every pass
    # smallest and largest length of a small reversal, drawn evenly on a logarithmic scale [rad]
    reversal_rad: tuple[float, float] = positive((1e-3, 3e-2))
    reversal_s: float = positive(0.5)  # length divided by speed of a small reversal [s]

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        shortest = min(self.longest_s, self.reversal_s) if self.reversals else self.longest_s
        if self.ease_s > shortest:
            expected = f"at most {shortest:g}, longest_s or, with reversals, reversal_s"
            raise UsageError(f"slow_sweep: ease_s {self.ease_s:g}: expected {expected}")
        low, high = self.range_rad
        wide = max(self.speeds_rad_s[1] * self.ease_s, self.reversal_rad[1] / 2 if self.reversals else 0.0)
        if -low < wide or high < wide:
            expected = f"a range around the start at 0, from {-wide:g} or less to {wide:g} or more"
            raise UsageError(f"slow_sweep: range_rad {low:g}, {high:g}: expected {expected}")

    def reference(self, ticks: int, dt: float, rng: np.random.Generator) -> Reference:
        """Return the strokes that fit, ending at 0; at rest throughout if the first there and back does not fit."""
        now, rows = REST_S, [np.zeros((3, 0))]
        for targets in _excursions(self, rng):
            positions, speeds = np.array(targets).T
            displacements = np.diff(positions, prepend=0.0)
            lasts = np.abs(displacements) / speeds + self.ease_s + self.dwell_s
            if now + lasts.sum() - self.dwell_s > ticks * dt - REST_S:
                break
            rows.append(np.stack([now + np.cumsum(lasts) - lasts, displacements, speeds]))
            now += float(lasts.sum())
        start, displacement, speed = np.hstack(rows)
        t = np.arange(ticks + 1, dtype=np.float64) * dt
        return constant_speed_strokes(t, start, displacement, speed, np.full(len(start), self.ease_s))


def _excursions(settings: SlowSweep, rng: np.random.Generator) -> Iterator[list[Target]]:
    speeds = np.geomspace(*settings.speeds_rad_s, settings.steps)
    sides = cycle(settings.range_rad)
    while True:
        if settings.reversals:  # to and fro about 0; a stroke, but for the first and the last, is within the limits
            smallest, largest = np.log(settings.reversal_rad)
            half = np.exp(rng.uniform(smallest, largest, settings.reversals)) / 2
            positions = np.append(half * (-1.0) ** np.arange(settings.reversals), 0.0)
            lengths = np.abs(np.diff(positions, prepend=0.0))
            yield list(zip(positions.tolist(), (lengths / settings.reversal_s).tolist(), strict=True))
        for speed in rng.permutation(speeds):
            far = float(speed) * settings.longest_s
            yield [(float(np.clip(next(sides), -far, far)), float(speed)), (0.0, float(speed))]


TOO_SHORT = 1e-9  # rounding of a stroke that is all rise and fall


class Stroke(NamedTuple):
    """A stroke and the rest after it."""

    displacement_rad: float  # signed; at least the speed times the ease [rad]
    speed_rad_s: float  # highest speed [rad/s]
    ease_s: float  # time of the rise of the velocity, and of its fall [s]
    rest_s: float  # rest afterwards [s]

    @property
    def duration_s(self) -> float:
        """How long it takes with the rest. [s]"""
        return abs(self.displacement_rad) / self.speed_rad_s + self.ease_s + self.rest_s


class Prescribed(Checked):
    """Strokes one after the other."""

    # in order: displacement [rad], highest speed [rad/s], ease [s], rest afterwards [s]
    strokes: tuple[Stroke, ...] = (Stroke(0.5, 0.5, 0.3, 0.5), Stroke(-0.5, 0.5, 0.3, 0.5)) * 4
    start_s: float = within(0.5)  # rest before the first one [s]

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        for one in self.strokes:
            displacement, speed, ease, rest = one
            least = speed * ease * (1.0 - TOO_SHORT)
            if not (min(speed, ease) > 0.0 <= rest and least <= abs(displacement) and all(map(isfinite, one))):
                found = ", ".join(f"{number:g}" for number in one)
                expected = "a length of at least speed times ease, both above zero, and a rest of zero or more"
                raise UsageError(f"prescribed: {found}: expected {expected}")

    def reference(self, ticks: int, dt: float, _: np.random.Generator) -> Reference:
        """Return the strokes; those that do not fit are cut off, after the last one there is rest."""
        t = np.arange(ticks + 1, dtype=np.float64) * dt
        displacement, speed, ease, _rest = np.array(self.strokes).reshape(-1, 4).T
        return constant_speed_strokes(t, start_times(self)[:-1], displacement, speed, ease)


def start_times(settings: Prescribed) -> Float:
    """Return when each stroke begins, and when the last rest ends, shape (m + 1,). [s]"""
    return settings.start_s + np.cumsum([0.0, *(one.duration_s for one in settings.strokes)])


SHORTEST_M = 1e-3  # a hand that reaches less far stands still
SMALL_RAD = 1e-3  # below this angle, the series of the Jacobian are exact to rounding


class HandPath(Checked):
    """Minimum-jerk strokes between via points drawn in a ball around the start, the orientation turning along.

    The defaults move all joints of a Panda that starts in its ready pose, the first one the least, within their limits.
    """

    reach_m: float = within(0.12, SHORTEST_M)  # radius of the ball of positions around the start [m]
    sideways: float = positive(2.5)  # the ball is so many times as wide along y, to the sides
    # radius of the ball of rotation vectors around the start orientation, below half a turn [rad]
    rotation_rad: float = within(0.6, 0.0, 3.14)
    # shortest and longest duration of a stroke, where neither the speed nor the reach cuts it [s]
    stroke_s: tuple[float, float] = within((0.9, 1.8), SHORTEST_S)
    # slowest and fastest peak speed; slower where the shortest stroke or the turn asks for it [m/s]
    speed_m_s: tuple[float, float] = positive((0.15, 0.6))
    turning_rad_s: float = positive(1.2)  # no stroke turns faster [rad/s]
    pause_s: tuple[float, float] = within((0.2, 0.7))  # shortest and longest pause between two strokes [s]


class HandMotion(NamedTuple):
    """The intended motion of the hand at the controller's ticks, shape (n + 1, 3) each, in the world's axes."""

    position: Float  # offset from the start [m]
    rotation: Float  # rotation vector r; the orientation is exp(r) times the start orientation [rad]
    velocity: Float  # derivative of the position [m/s]
    angular: Float  # angular velocity [rad/s]


def plan_hand(settings: HandPath, ticks: int, dt: float, rng: np.random.Generator) -> HandMotion:
    """Draw the strokes that fit between a rest at the start and a rest at the end; at rest if not one fits."""
    # A rest and strokes: start [s], duration [s], origin and change of the pose [m, rad].
    begin, pose, rows = REST_S, np.zeros(6), [np.array([0.0, REST_S, *np.zeros(12)])]
    while True:
        needed, change = _draw_stroke(settings, pose, rng)
        if begin + needed > ticks * dt - REST_S:
            break
        rows.append(np.concatenate(([begin, needed], pose, change)))
        begin += needed + rng.uniform(*settings.pause_s)
        pose = pose + change
    strokes, t = np.array(rows), np.arange(ticks + 1, dtype=np.float64) * dt
    start, lasts, origin, change = np.split(strokes[segment_at(strokes[:, 0], t)], [1, 2, 8], axis=1)
    covered, slope = min_jerk((t[:, np.newaxis] - start) / lasts)
    position, rotation = np.hsplit(origin + covered * change, 2)
    velocity, turning = np.hsplit(slope / lasts * change, 2)
    # The angular velocity in the world's axes, by the left Jacobian of the rotation group.
    angle = np.linalg.norm(rotation, axis=1)
    safe = np.maximum(angle, SMALL_RAD)
    first = np.where(angle > SMALL_RAD, 2 * (np.sin(safe / 2) / safe) ** 2, 0.5 - angle**2 / 24)
    second = np.where(angle > SMALL_RAD, (safe - np.sin(safe)) / safe**3, 1 / 6 - angle**2 / 120)
    across = np.cross(rotation, turning)
    angular = turning + first[:, np.newaxis] * across + second[:, np.newaxis] * np.cross(rotation, across)
    return HandMotion(position, rotation, velocity, angular)


def _draw_stroke(settings: HandPath, pose: Float, rng: np.random.Generator) -> tuple[float, Float]:
    """Draw duration [s] and change, shape (6,) [m, rad], of a stroke towards a via point half the reach off or more."""
    while True:
        position = settings.reach_m * _draw_in_ball(rng) * (1.0, settings.sideways, 1.0)
        if np.linalg.norm(position - pose[:3]) >= settings.reach_m / 2:
            break
    change = np.concatenate((position, settings.rotation_rad * _draw_in_ball(rng))) - pose
    distance = float(np.linalg.norm(change[:3]))
    speed = float(np.exp(rng.uniform(*np.log(settings.speed_m_s))))
    length = min(distance, speed * rng.uniform(*settings.stroke_s) / PEAK)
    change *= length / distance
    turn = float(np.linalg.norm(change[3:]))
    return max(PEAK * length / speed, PEAK * turn / settings.turning_rad_s, settings.stroke_s[0]), change


def _draw_in_ball(rng: np.random.Generator) -> Float:
    direction = rng.standard_normal(3)
    point: Float = direction / np.linalg.norm(direction) * rng.random() ** (1 / 3)
    return point
