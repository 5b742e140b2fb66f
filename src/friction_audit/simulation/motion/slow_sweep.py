"""Slow sweep: constant speeds from very slow to fast, there and back, for what friction does near rest."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import cycle
from math import inf

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.motion.motion import REST_S, Intention, at_constant_speed, tick_times
from friction_audit.simulation.settings import require_order, require_positive, require_within

WHERE = "slow-sweep"

Target = tuple[float, float]  # a place to go to [rad] and the speed to go with [rad/s]
MOST = 1000  # speeds or small reversals of a pass: more would outlast every recording


@dataclass(frozen=True, kw_only=True, slots=True)
class SlowSweep:
    """Strokes of constant speed from the start to one side and back, at the next speed to the other side and back.

    The speeds come in an order drawn anew for every pass, so that speed and time are not mistaken for each other. A
    pass with the usual settings takes less than a minute.

    Raises:
        UsageError: If a number has the wrong sign, a pair the wrong order, or the range is too narrow for the fastest
            speed or for the reversals.
    """

    speeds_rad_s: tuple[float, float] = (0.01, 1.0)  # slowest and fastest speed [rad/s]
    steps: int = 7  # number of speeds in a pass, evenly spaced on a logarithmic scale
    range_rad: tuple[float, float] = (-0.6, 0.6)  # lowest and highest position, relative to the start [rad]
    longest_s: float = 3.0  # A stroke turns back after this time although the range goes on [s]
    dwell_s: float = 0.3  # rest after every stroke [s]
    ease_s: float = 0.2  # time in which a stroke reaches its speed, and in which it loses it [s]
    reversals: int = 0  # number of small reversals at the start of every pass
    # smallest and largest way of a small reversal, drawn evenly on a logarithmic scale [rad]
    reversal_rad: tuple[float, float] = (1e-3, 3e-2)
    reversal_s: float = 0.5  # way divided by speed of a small reversal [s]

    def __post_init__(self) -> None:
        require_positive(WHERE, slowest_rad_s=self.speeds_rad_s[0], smallest_reversal_rad=self.reversal_rad[0])
        require_positive(WHERE, longest_s=self.longest_s, reversal_s=self.reversal_s, ease_s=self.ease_s)
        require_within(WHERE, 1, MOST, steps=self.steps)
        require_within(WHERE, 0, MOST, reversals=self.reversals)
        require_within(WHERE, 0, inf, dwell_s=self.dwell_s)
        pairs = {"speeds_rad_s": self.speeds_rad_s, "range_rad": self.range_rad, "reversal_rad": self.reversal_rad}
        require_order(WHERE, **pairs)
        shortest = min(self.longest_s, self.reversal_s) if self.reversals else self.longest_s
        if self.ease_s > shortest:
            raise UsageError(
                f"{WHERE}: ease_s {self.ease_s:g}: expected at most {shortest:g}, "
                "longest_s or, with reversals, reversal_s"
            )
        wide = max(self.speeds_rad_s[1] * self.ease_s, self.reversal_rad[1] / 2 if self.reversals else 0.0)
        if -self.range_rad[0] < wide or self.range_rad[1] < wide:
            raise UsageError(
                f"{WHERE}: range_rad {self.range_rad[0]:g}, {self.range_rad[1]:g}: expected a range around the start "
                f"at 0, from {-wide:g} or less to {wide:g} or more"
            )


def intend(settings: SlowSweep, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return the strokes that fit, ending at 0; at rest throughout if the first there and back does not fit."""
    start, way, speed = _plan(settings, ticks * dt, rng)
    return at_constant_speed(tick_times(ticks, dt), start, way, speed, np.full(len(start), settings.ease_s))


def _plan(settings: SlowSweep, duration_s: float, rng: np.random.Generator) -> tuple[Float, Float, Float]:
    """Return start [s], signed way [rad] and speed [rad/s] of the strokes that fit, each of shape (m,)."""
    start: list[float] = []
    way: list[float] = []
    speed: list[float] = []
    now = REST_S
    for targets in _excursions(settings, rng):
        places, speeds = np.array(targets).T
        ways = np.diff(places, prepend=0.0)
        lasts = np.abs(ways) / speeds + settings.ease_s + settings.dwell_s
        if now + lasts.sum() - settings.dwell_s > duration_s - REST_S:
            break
        start.extend(now + np.cumsum(lasts) - lasts)
        way.extend(ways)
        speed.extend(speeds)
        now += float(lasts.sum())
    return np.array(start), np.array(way), np.array(speed)


def _excursions(settings: SlowSweep, rng: np.random.Generator) -> Iterator[list[Target]]:
    speeds = np.geomspace(*settings.speeds_rad_s, settings.steps)
    sides = cycle(settings.range_rad)
    while True:
        if settings.reversals:
            yield _reversals(settings, rng)
        for speed in rng.permutation(speeds):
            far = float(speed) * settings.longest_s
            yield [(float(np.clip(next(sides), -far, far)), float(speed)), (0.0, float(speed))]


def _reversals(settings: SlowSweep, rng: np.random.Generator) -> list[Target]:
    """Draw small reversals to and fro about 0; a way, but for the first and the last, is within the limits."""
    smallest, largest = np.log(settings.reversal_rad)
    half = np.exp(rng.uniform(smallest, largest, settings.reversals)) / 2
    places = [*(half * (-1.0) ** np.arange(settings.reversals)), 0.0]
    ways = np.abs(np.diff(places, prepend=0.0))
    return [(float(place), float(way / settings.reversal_s)) for place, way in zip(places, ways, strict=True)]
