"""Stop and go: minimum-jerk strokes with pauses between them, back and forth in a range."""

from dataclasses import dataclass
from math import inf
from statistics import NormalDist

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.motion.motion import (
    PEAK,
    REST_S,
    SHORTEST_S,
    Intention,
    course,
    latest,
    slope,
    tick_times,
)
from friction_audit.simulation.settings import require_order, require_positive, require_within

WHERE = "stop-and-go"

STRATA = 10  # the speeds of so many strokes in a row are spread evenly over their distribution
TINY = 1e-9  # keeps a rank off 0, whose normal deviate is infinite


@dataclass(frozen=True, kw_only=True, slots=True)
class StopAndGo:
    """Strokes of a person who stops between them.

    Raises:
        UsageError: If a number has the wrong sign, a pair the wrong order, or the start is outside of the range.
    """

    # shortest and longest duration of a stroke; its length follows from the peak speed [s]
    stroke_s: tuple[float, float] = (0.9, 1.8)
    speed_rad_s: float = 0.9  # mean of the strokes' peak speeds [rad/s]
    speed_spread: float = 0.4  # coefficient of variation of the strokes' peak speeds
    speed_limits_rad_s: tuple[float, float] = (0.3, 1.8)  # no stroke has a slower or a faster peak [rad/s]
    pause_s: tuple[float, float] = (0.2, 0.7)  # shortest and longest pause between two strokes [s]
    range_rad: tuple[float, float] = (-1.2, 1.2)  # lowest and highest position, relative to the start [rad]
    reversing: float = 0.8  # share of the strokes that turn back, where the range leaves the choice

    def __post_init__(self) -> None:
        pairs = ("stroke_s", "speed_limits_rad_s", "pause_s", "range_rad")
        require_positive(WHERE, speed_rad_s=self.speed_rad_s)
        require_positive(WHERE, slowest_rad_s=self.speed_limits_rad_s[0])
        require_within(WHERE, SHORTEST_S, inf, shortest_stroke_s=self.stroke_s[0])
        require_within(WHERE, 0, inf, speed_spread=self.speed_spread, shortest_pause_s=self.pause_s[0])
        require_within(WHERE, 0, 1, reversing=self.reversing)
        require_order(WHERE, **{name: getattr(self, name) for name in pairs})
        low, high = self.range_rad
        if not low <= 0 <= high or low == high:
            raise UsageError(f"{WHERE}: range_rad {low:g}, {high:g}: expected a range around the start at 0")


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Strokes:
    """Strokes of the intended motion, one row each, shape (m,)."""

    start_s: Float  # when the stroke begins [s]
    duration_s: Float  # how long it takes [s]
    origin_rad: Float  # where it begins [rad]
    length_rad: Float  # where it ends, relative to the origin; the sign is the direction [rad]

    @property
    def peak_speed_rad_s(self) -> Float:
        """Peak speeds, shape (m,). [rad/s]"""
        return PEAK * np.abs(self.length_rad) / self.duration_s


def intend(settings: StopAndGo, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return strokes at the ticks of the controller; at rest throughout if not one fits."""
    strokes = plan_strokes(settings, ticks * dt, rng)
    position, velocity = intended_motion(strokes, tick_times(ticks, dt))
    return Intention(position=position, velocity=velocity)


def plan_strokes(settings: StopAndGo, duration_s: float, rng: np.random.Generator) -> Strokes:
    """Draw the strokes that fit between a rest at the start and a rest at the end."""
    rows: list[tuple[float, float, float, float]] = []
    speeds: list[float] = []
    start, place, direction = REST_S, 0.0, 1.0
    while True:
        speeds = speeds or _draw_speeds(settings, rng)
        speed = speeds.pop()
        length = _draw_length(settings, speed, place, direction, rng)
        lasts = PEAK * abs(length) / speed
        if start + lasts > duration_s - REST_S:
            break
        rows.append((start, lasts, place, length))
        start += lasts + rng.uniform(*settings.pause_s)
        place, direction = place + length, float(np.sign(length))
    table = np.asarray(rows, dtype=np.float64).reshape(-1, 4)
    return Strokes(start_s=table[:, 0], duration_s=table[:, 1], origin_rad=table[:, 2], length_rad=table[:, 3])


def _draw_speeds(settings: StopAndGo, rng: np.random.Generator) -> list[float]:
    """Draw the peak speeds of the next strokes: log-normal, stratified, within the limits."""
    ranks = (rng.permutation(STRATA) + rng.uniform(TINY, 1.0, STRATA)) / STRATA
    sigma = np.sqrt(np.log1p(settings.speed_spread**2))
    deviates = np.array([NormalDist().inv_cdf(rank) for rank in ranks])
    speeds = settings.speed_rad_s * np.exp(sigma * deviates - sigma**2 / 2)
    return [float(speed) for speed in np.clip(speeds, *settings.speed_limits_rad_s)]


def _draw_length(settings: StopAndGo, speed: float, place: float, direction: float, rng: np.random.Generator) -> float:
    """Draw the signed length of the next stroke; it mostly turns back and always stays in the range."""
    low, high = settings.range_rad
    length = speed * rng.uniform(*settings.stroke_s) / PEAK
    turned = -direction if rng.random() < settings.reversing else direction
    for way in (turned, -turned):
        if low <= place + way * length <= high:
            return way * length
    return (high - place) if high - place > place - low else (low - place)


def intended_motion(strokes: Strokes, t: Float) -> tuple[Float, Float]:
    """Return the intended position [rad] and velocity [rad/s] at the times t, each of shape (n,)."""
    if not len(strokes.start_s):
        return np.zeros_like(t), np.zeros_like(t)
    stroke = latest(strokes.start_s, t)
    lasts, length = strokes.duration_s[stroke], strokes.length_rad[stroke]
    x = np.clip((t - strokes.start_s[stroke]) / lasts, 0.0, 1.0)
    return strokes.origin_rad[stroke] + length * course(x), length / lasts * slope(x)
