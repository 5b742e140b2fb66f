"""Commanded: a robot excites itself by a multisine, as identification practice has it (Swevers et al., 1997)."""

from dataclasses import dataclass

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.motion.motion import Intention, rising, slope, tick_times
from friction_audit.simulation.settings import require_order, require_positive, require_within

WHERE = "commanded"
STRIDE = 7  # a joint takes every seventh frequency; arms with more joints take as many as they have joints
MOST_SINES = 100  # more are noise, and take as many primes


@dataclass(frozen=True, kw_only=True, slots=True)
class Commanded:
    """A sum of sines of equal speed and random phase, scaled until it meets the range or the peak speed.

    The frequencies go with the square roots of the primes: no sum of some is ever a multiple of others, neither in one
    joint nor across joints.

    Raises:
        UsageError: If a number has the wrong sign or the start is not inside the range.
    """

    lowest_hz: float = 0.1  # lowest frequency, that of the first joint [Hz]
    sines: int = 5  # number of sines; five reach up to 7.3 times the lowest frequency
    range_rad: tuple[float, float] = (-0.8, 0.8)  # lowest and highest position, relative to the start [rad]
    peak_speed_rad_s: float = 1.2  # highest speed [rad/s]
    ease_s: float = 2.0  # time of the smooth start, and of the smooth end [s]

    def __post_init__(self) -> None:
        require_positive(WHERE, lowest_hz=self.lowest_hz, ease_s=self.ease_s)
        require_within(WHERE, 1, MOST_SINES, sines=self.sines)
        require_positive(WHERE, peak_speed_rad_s=self.peak_speed_rad_s)
        require_order(WHERE, range_rad=self.range_rad)
        low, high = self.range_rad
        if not low < 0 < high:
            raise UsageError(f"{WHERE}: range_rad {low:g}, {high:g}: expected a range around the start at 0")


def intend(settings: Commanded, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return the multisine of one joint; it starts and ends at rest at 0."""
    joints = intend_joints(settings, 1, ticks, dt, rng)
    return Intention(position=joints.position[:, 0], velocity=joints.velocity[:, 0])


def intend_joints(settings: Commanded, joints: int, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return a multisine for each of the joints, shape (ticks + 1, joints), all frequencies different."""
    t = tick_times(ticks, dt)
    pulsation = 2 * np.pi * frequencies_hz(settings, joints)
    phase = rng.uniform(0.0, 2 * np.pi, pulsation.shape)
    envelope, steepness = _envelope(t, min(settings.ease_s, t[-1] / 2))
    position, velocity = np.empty((2, ticks + 1, joints))
    for joint in range(joints):
        # One joint at a time keeps the arrays inside the cache.
        angle = np.outer(t, pulsation[joint]) + phase[joint]
        swing, speed = np.sin(angle) @ (1 / pulsation[joint]), np.cos(angle).sum(axis=1)
        position[:, joint], velocity[:, joint] = envelope * swing, steepness * swing + envelope * speed
    excess = _excess(settings, position, velocity)
    return Intention(position=position / excess, velocity=velocity / excess)


def frequencies_hz(settings: Commanded, joints: int) -> Float:
    """Return the frequencies, shape (joints, sines). [Hz]"""
    stride = max(STRIDE, joints)
    roots = np.sqrt(_primes(stride * settings.sines) / 2)
    return settings.lowest_hz * roots.reshape(settings.sines, stride).T[:joints]


def _primes(count: int) -> Float:
    """Return the first primes, shape (count,), by Eratosthenes' sieve below Rosser's bound n (ln n + ln ln n)."""
    limit = int(count * (np.log(count) + np.log(np.log(count)))) + 1
    prime = np.ones(limit + 1, dtype=bool)
    prime[:2] = False
    for number in range(2, int(limit**0.5) + 1):
        prime[number * number :: number] &= not prime[number]
    return np.flatnonzero(prime)[:count].astype(np.float64)


def _envelope(t: Float, ease_s: float) -> tuple[Float, Float]:
    """Return a factor that rises from 0 to 1 and falls to 0 at the end, and its derivative [1/s], shape of t."""
    rise, fall = t / ease_s, (t[-1] - t) / ease_s
    steepness = slope(np.clip(rise, 0.0, 1.0)) - slope(np.clip(fall, 0.0, 1.0))
    return np.minimum(rising(rise), rising(fall)), steepness / ease_s


def _excess(settings: Commanded, position: Float, velocity: Float) -> Float:
    """Return by how much each joint exceeds the tighter of its bounds, shape (joints,); 1 where nothing moves."""
    low, high = settings.range_rad
    peaks = (position.max(axis=0) / high, position.min(axis=0) / low, np.abs(velocity).max(axis=0))
    excess: Float = np.maximum.reduce([*peaks[:2], peaks[2] / settings.peak_speed_rad_s])
    return np.where(excess > 0, excess, 1.0)
