"""The motion that the person intends: minimum-jerk strokes with pauses (stop and go)."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulate.settings import Operator

MINIMUM_JERK_PEAK = 1.875
"""Peak speed of a minimum-jerk stroke of length 1 in time 1."""

REST_S = 0.5
"""Rest before the first stroke and after the last. [s]"""

STRATA = 10
"""The speeds of so many strokes in a row are spread evenly over their distribution."""

TINY = 1e-9
"""Keeps a rank off 0, whose normal deviate is infinite."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Strokes:
    """Strokes of the intended motion, one row each, shape (m,).

    Attributes:
        start_s: When the stroke begins. [s]
        duration_s: How long it takes. [s]
        origin_rad: Where it begins. [rad]
        length_rad: Where it ends, relative to the origin; the sign is the direction. [rad]
    """

    start_s: Float
    duration_s: Float
    origin_rad: Float
    length_rad: Float

    @property
    def peak_speed_rad_s(self) -> Float:
        """Peak speeds, shape (m,). [rad/s]"""
        return MINIMUM_JERK_PEAK * np.abs(self.length_rad) / self.duration_s


def plan_strokes(operator: Operator, duration_s: float, rng: np.random.Generator) -> Strokes:
    """Draw the strokes that fit between a rest at the start and a rest at the end."""
    rows: list[tuple[float, float, float, float]] = []
    speeds: list[float] = []
    start, place, direction = REST_S, 0.0, 1.0
    while True:
        speeds = speeds or _draw_speeds(operator, rng)
        speed = speeds.pop()
        length = _draw_length(operator, speed, place, direction, rng)
        lasts = MINIMUM_JERK_PEAK * abs(length) / speed
        if start + lasts > duration_s - REST_S:
            break
        rows.append((start, lasts, place, length))
        start += lasts + rng.uniform(*operator.pause_s)
        place, direction = place + length, float(np.sign(length))
    table = np.asarray(rows, dtype=np.float64).reshape(-1, 4)
    return Strokes(start_s=table[:, 0], duration_s=table[:, 1], origin_rad=table[:, 2], length_rad=table[:, 3])


def _draw_speeds(operator: Operator, rng: np.random.Generator) -> list[float]:
    """Draw the peak speeds of the next strokes: log-normal, stratified, within the limits."""
    ranks = (rng.permutation(STRATA) + rng.uniform(TINY, 1.0, STRATA)) / STRATA
    sigma = np.sqrt(np.log1p(operator.speed_spread**2))
    deviates = np.array([NormalDist().inv_cdf(rank) for rank in ranks])
    speeds = operator.speed_rad_s * np.exp(sigma * deviates - sigma**2 / 2)
    return [float(speed) for speed in np.clip(speeds, *operator.speed_limits_rad_s)]


def _draw_length(operator: Operator, speed: float, place: float, direction: float, rng: np.random.Generator) -> float:
    """Draw the signed length of the next stroke; it mostly turns back and always stays in the range."""
    low, high = operator.range_rad
    length = speed * rng.uniform(*operator.stroke_s) / MINIMUM_JERK_PEAK
    turned = -direction if rng.random() < operator.reversing else direction
    for way in (turned, -turned):
        if low <= place + way * length <= high:
            return way * length
    return (high - place) if high - place > place - low else (low - place)


def intended_motion(strokes: Strokes, t: Float) -> tuple[Float, Float]:
    """Return the intended position [rad] and velocity [rad/s] at the times t, each of shape (n,)."""
    if not len(strokes.start_s):
        return np.zeros_like(t), np.zeros_like(t)
    stroke = np.maximum(np.searchsorted(strokes.start_s, t, side="right") - 1, 0)
    lasts, length = strokes.duration_s[stroke], strokes.length_rad[stroke]
    x = np.clip((t - strokes.start_s[stroke]) / lasts, 0.0, 1.0)
    position = strokes.origin_rad[stroke] + length * (x * x * x * (10.0 + x * (6.0 * x - 15.0)))
    velocity = length / lasts * (30.0 * x * x * (1.0 - x) * (1.0 - x))
    return position, velocity
