"""Periodic motions: a sinusoid, and the multisine by which a robot excites itself (Swevers et al., 1997)."""

from itertools import count, islice
from math import isqrt, pi

import numpy as np

from friction_audit.compensation.law import FINITE, Checked, positive, within
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.strokes import SHORTEST_S, Prescribed, Reference, SlowSweep, StopAndGo, area, min_jerk

WIDEST = 0.5  # up to this spread, the speed never changes its sign inside a half-period
ROUNDING = 1e-9  # a half-period that ends with the recording still fits


class Sinusoid(Checked):
    """Position A (1 - cos(2 pi t / T)): from rest at 0 to 2 A and back, as in the paper's simulations."""

    amplitude_rad: float = positive(0.5)  # half the travel, A [rad]
    period_s: float = within(4.0, SHORTEST_S)  # period of a there and back, T [s]
    # largest relative change of the amplitude; each end of the travel after the first draws its own, evenly
    # distributed, and the amplitude passes smoothly from one to the next
    spread: float = within(0.0, 0.0, WIDEST)
    # time in which the sinusoid picks up its speed; 0 for at once. It comes late by half of that [s]
    ease_s: float = within(0.0)

    def reference(self, ticks: int, dt: float, rng: np.random.Generator) -> Reference:
        """Return the whole half-periods that fit, then rest; at rest throughout if not one fits."""
        t, half_period = np.arange(ticks + 1, dtype=np.float64) * dt, self.period_s / 2
        # How many half-periods have passed, and how many pass in a second.
        halves, halves_per_s = t / half_period, np.full_like(t, 1 / half_period)
        if self.ease_s > 0:
            eased = t / self.ease_s
            halves, halves_per_s = self.ease_s * area(eased) / half_period, min_jerk(eased)[0] / half_period
        fitting = int(halves[-1] + ROUNDING)
        halves_per_s[halves >= fitting] = 0.0
        halves = np.minimum(halves, fitting)
        # The amplitude passes from one end of the travel to the next.
        ends = self.amplitude_rad * (1.0 + self.spread * rng.uniform(-1.0, 1.0, fitting + 2))
        ends[0] = self.amplitude_rad
        end = np.minimum(np.floor(halves), fitting).astype(np.intp)
        passed, change = halves - end, np.diff(ends)[end]
        covered, slope = min_jerk(passed)
        amplitude, change = ends[end] + change * covered, change * slope
        half = np.minimum(np.floor(halves), max(fitting - 1, 0))
        x, side = halves - half, np.where(half % 2 == 0, 1.0, -1.0)
        rate = pi * amplitude * np.sin(pi * x) - change * np.cos(pi * x)
        position = self.amplitude_rad - side * amplitude * np.cos(pi * x)
        return Reference(position, side * rate * halves_per_s)


STRIDE = 7  # a joint takes every seventh frequency; arms with more joints take as many as they have joints
MOST_SINES = 100  # more are noise, and take as many primes


class Commanded(Checked):
    """A sum of sines of equal speed and random phase, scaled until it meets the range or the peak speed.

    The frequencies go with the square roots of the primes: no sum of some is ever a multiple of others, neither in one
    joint nor across joints.
    """

    lowest_hz: float = positive(0.1)  # lowest frequency, that of the first joint [Hz]
    sines: int = within(5, 1, MOST_SINES)  # number of sines; five reach up to 7.3 times the lowest frequency
    range_rad: tuple[float, float] = within((-0.8, 0.8), -FINITE)  # lowest and highest position, from the start [rad]
    peak_speed_rad_s: float = positive(1.2)  # highest speed [rad/s]
    ease_s: float = positive(2.0)  # time of the smooth start, and of the smooth end [s]

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        low, high = self.range_rad
        if not low < 0 < high:
            raise UsageError(f"commanded: range_rad {low:g}, {high:g}: expected a range around the start at 0")

    def reference(self, ticks: int, dt: float, rng: np.random.Generator) -> Reference:
        """Return the multisine of one joint; it starts and ends at rest at 0."""
        return Reference(*(signal[:, 0] for signal in multisine(self, 1, ticks, dt, rng)))


def multisine(settings: Commanded, joints: int, ticks: int, dt: float, rng: np.random.Generator) -> Reference:
    """Return a multisine for each of the joints, shape (ticks + 1, joints), all frequencies different."""
    t = np.arange(ticks + 1, dtype=np.float64) * dt
    pulsation = 2 * np.pi * frequencies_hz(settings, joints)
    phase = rng.uniform(0.0, 2 * np.pi, pulsation.shape)
    # A factor that rises from 0 to 1 and falls to 0 at the end, and its derivative [1/s].
    ease_s = min(settings.ease_s, t[-1] / 2)
    (rise, steeper), (fall, flatter) = min_jerk(t / ease_s), min_jerk((t[-1] - t) / ease_s)
    envelope, steepness = np.minimum(rise, fall), (steeper - flatter) / ease_s
    position, velocity = np.empty((2, ticks + 1, joints))
    for joint in range(joints):
        # One joint at a time keeps the arrays inside the cache.
        angle = np.outer(t, pulsation[joint]) + phase[joint]
        swing, speed = np.sin(angle) @ (1 / pulsation[joint]), np.cos(angle).sum(axis=1)
        position[:, joint], velocity[:, joint] = envelope * swing, steepness * swing + envelope * speed
    # By how much each joint exceeds the tighter of its bounds; 1 where nothing moves.
    low, high = settings.range_rad
    speed = np.abs(velocity).max(axis=0) / settings.peak_speed_rad_s
    excess = np.maximum.reduce([position.max(axis=0) / high, position.min(axis=0) / low, speed])
    excess = np.where(excess > 0, excess, 1.0)
    return Reference(position / excess, velocity / excess)


def frequencies_hz(settings: Commanded, joints: int) -> Float:
    """Return the frequencies, shape (joints, sines). [Hz]"""
    stride = max(STRIDE, joints)
    primes = (n for n in count(2) if all(n % k for k in range(2, isqrt(n) + 1)))
    roots = np.sqrt(np.array(list(islice(primes, stride * settings.sines))) / 2)
    return settings.lowest_hz * roots.reshape(settings.sines, stride).T[:joints]


# Reference trajectories of one joint, by a person or a robot: ``settings.reference(ticks, dt, rng)`` is the position
# and velocity at the ticks + 1 instants of the controller, from rest at 0.
MotionSettings = StopAndGo | Sinusoid | SlowSweep | Commanded | Prescribed
