"""Where a joint is asked to go: positions [rad] in steps of STEP_S, and how firmly it is held."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from benchmarks.stranger.joint import STEP_S

Array = NDArray[np.float64]
Motion = Callable[[np.random.Generator, float], tuple[Array, Array]]


def times(duration_s: float) -> Array:
    """Moments of a motion. [s]"""
    return np.asarray(np.arange(round(duration_s / STEP_S)) * STEP_S, np.float64)


def minimum_jerk(share: Array) -> Array:
    """Flash and Hogan's (1985) way from 0 to 1 over a share of the time from 0 to 1."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10 - 15 * s + 6 * s**2))


def reaches(rng: np.random.Generator, duration_s: float) -> tuple[Array, Array]:
    """An operator goes to and fro from point to point, rests, and in some of the rests lets go."""
    t = times(duration_s)
    wanted, grip = np.zeros(t.size), np.ones(t.size)
    now, here, side = 0.5, 0.0, 1.0
    while now < duration_s - 3.0:
        there = side * rng.uniform(0.15, 0.7)
        long_s = abs(there - here) * 1.875 / rng.uniform(0.35, 1.6)
        wanted += (there - here) * minimum_jerk((t - now) / long_s)
        now += long_s
        rest = rng.choice([0.0, rng.uniform(0.2, 0.8), rng.uniform(0.8, 2.5)], p=[0.45, 0.35, 0.2])
        if rest > 0.8:
            grip[(t > now + 0.3) & (t < now + rest - 0.1)] = 0.0
        now, here, side = now + rest, there, -side
    return wanted, np.convolve(grip, np.full(500, 1 / 500), "same")


def chirp(rng: np.random.Generator, duration_s: float) -> tuple[Array, Array]:
    """A sine that gets faster and slower again, its speed bounded."""
    t = times(duration_s)
    low, high = rng.uniform(0.15, 0.3), rng.uniform(0.8, 1.6)
    hertz = low * (high / low) ** (0.5 - 0.5 * np.cos(2 * np.pi * t / duration_s))
    amplitude = np.minimum(rng.uniform(0.5, 0.8), rng.uniform(1.0, 1.8) / (2 * np.pi * hertz))
    return eased(amplitude * np.sin(2 * np.pi * np.cumsum(hertz) * STEP_S)), np.ones(t.size)


def multisine(rng: np.random.Generator, duration_s: float) -> tuple[Array, Array]:
    """Five tones with phases by chance."""
    t = times(duration_s)
    hertz, phase = rng.uniform(0.1, 1.0, 5), rng.uniform(0, 2 * np.pi, 5)
    sines = np.sin(2 * np.pi * hertz[:, None] * t + phase[:, None]) / hertz[:, None] ** 0.7
    wanted = sines.sum(axis=0)
    return eased(wanted * rng.uniform(1.2, 2.0) / np.abs(np.gradient(wanted, STEP_S)).max()), np.ones(t.size)


def spline(rng: np.random.Generator, duration_s: float) -> tuple[Array, Array]:
    """A smooth curve through points by chance."""
    knots = np.cumsum(rng.uniform(0.7, 1.8, round(duration_s)))
    knots = np.concatenate(([0.0], knots[knots < duration_s - 2], [duration_s]))
    points = rng.uniform(-0.6, 0.6, knots.size)
    points[[0, -1]] = 0.0
    return np.asarray(CubicSpline(knots, points, bc_type="clamped")(times(duration_s))), np.ones(times(duration_s).size)


def stop_and_go(rng: np.random.Generator, duration_s: float) -> tuple[Array, Array]:
    """Strokes of constant speed between rests, from creeping to fast."""
    speed = np.zeros(times(duration_s).size)
    now, here, side = 0.5, 0.0, 1.0
    while now < duration_s - 4.0:
        fast = float(rng.choice([rng.uniform(0.22, 0.4), rng.uniform(0.4, 1.0), rng.uniform(1.0, 1.6)]))
        there = side * rng.uniform(0.15, 0.6)
        long_s = abs(there - here) / fast
        speed[round(now / STEP_S) : round((now + long_s) / STEP_S)] = side * fast
        now, here, side = now + long_s + rng.uniform(0.15, 1.0), there, -side
    ramp = np.full(1000, 1 / 1000)
    smooth = np.convolve(np.convolve(speed, ramp, "same"), ramp, "same")
    return np.cumsum(smooth) * STEP_S, np.ones(speed.size)


def eased(wanted: Array, ease_s: float = 1.5) -> Array:
    """A motion that begins and ends at rest."""
    t = times(wanted.size * STEP_S)
    return wanted[:1] + (wanted - wanted[:1]) * minimum_jerk(t / ease_s) * minimum_jerk((t[-1] - t) / ease_s)


MOTIONS: dict[str, Motion] = {
    "reaches": reaches,
    "chirp": chirp,
    "multisine": multisine,
    "spline": spline,
    "stop_and_go": stop_and_go,
}


def tremor(rng: np.random.Generator, n: int) -> Array:
    """How a hand shakes: 8 to 12 Hz, 0.3 mrad rms. [rad]"""
    band = butter(2, (8.0, 12.0), "bandpass", fs=1 / STEP_S, output="sos")
    shaking = sosfiltfilt(band, rng.normal(size=n))
    return np.asarray(3e-4 * shaking / shaking.std())
