"""Sinusoid: back and forth about a centre, from rest at one end of the travel; every half-period is an energy cycle."""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.motion.motion import SHORTEST_S, Intention, area, course, rising, slope, tick_times
from friction_audit.simulation.settings import require_positive, require_within

WHERE = "sinusoid"

WIDEST = 0.5  # up to this spread, the speed never changes its sign inside a half-period
ROUNDING = 1e-9  # a half-period that ends with the recording still fits


@dataclass(frozen=True, kw_only=True, slots=True)
class Sinusoid:
    """Position A (1 - cos(2 pi t / T)): from rest at 0 to 2 A and back, as in the paper's simulations.

    Raises:
        UsageError: If a number has the wrong sign or the spread is above one half.
    """

    amplitude_rad: float = 0.5  # half the travel, A [rad]
    period_s: float = 4.0  # period of a there and back, T [s]
    # largest relative change of the amplitude; each end of the travel after the first draws its own, evenly
    # distributed, and the amplitude passes smoothly from one to the next
    spread: float = 0.0
    # time in which the sinusoid picks up its pace; 0 for at once. It comes late by half of that [s]
    ease_s: float = 0.0

    def __post_init__(self) -> None:
        require_positive(WHERE, amplitude_rad=self.amplitude_rad, period_s=self.period_s)
        require_within(WHERE, SHORTEST_S, inf, period_s=self.period_s)
        require_within(WHERE, 0, WIDEST, spread=self.spread)
        require_within(WHERE, 0, inf, ease_s=self.ease_s)


def intend(settings: Sinusoid, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return the whole half-periods that fit, then rest; at rest throughout if not one fits."""
    halves, pace = _pace(tick_times(ticks, dt), settings)
    fitting = int(halves[-1] + ROUNDING)
    pace[halves >= fitting] = 0.0
    halves = np.minimum(halves, fitting)
    amplitude, change = _amplitude(settings, halves, fitting, rng)
    half = np.minimum(np.floor(halves), max(fitting - 1, 0))
    x, side = halves - half, np.where(half % 2 == 0, 1.0, -1.0)
    rate = pi * amplitude * np.sin(pi * x) - change * np.cos(pi * x)
    position = settings.amplitude_rad - side * amplitude * np.cos(pi * x)
    return Intention(position=position, velocity=side * rate * pace)


def _pace(t: Float, settings: Sinusoid) -> tuple[Float, Float]:
    """Return how many half-periods have passed and how many pass in a second [1/s], both of the shape of t."""
    half_period = settings.period_s / 2
    if settings.ease_s == 0:
        return t / half_period, np.full_like(t, 1 / half_period)
    eased = t / settings.ease_s
    return settings.ease_s * area(eased) / half_period, rising(eased) / half_period


def _amplitude(settings: Sinusoid, halves: Float, fitting: int, rng: np.random.Generator) -> tuple[Float, Float]:
    """Return the amplitude and its derivative by the number of half-periods, both of the shape of halves. [rad]"""
    ends = settings.amplitude_rad * (1.0 + settings.spread * rng.uniform(-1.0, 1.0, fitting + 2))
    ends[0] = settings.amplitude_rad
    half = np.minimum(np.floor(halves), fitting).astype(np.intp)
    x, change = halves - half, np.diff(ends)[half]
    return ends[half] + change * course(x), change * slope(x)
