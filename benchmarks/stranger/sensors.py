"""What a recorder writes of a motion: sampled at its own moments, counted in steps, noisy, late, and not all of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.stranger.joint import STEP_S

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """How one joint is recorded."""

    rate_hz: float = 1000.0
    torque_noise_nm: float = 0.055
    noise_memory_s: float = 0.03
    torque_step_nm: float = 0.0357
    encoder_bits: int = 18
    tachometer: bool = True
    speed_noise_rad_s: float = 0.0027
    difference_hz: float = 50.0
    clock: str = "late_stamps"
    jitter_s: float = 1.9e-4
    lost: float = 0.02
    repeated: float = 0.1
    torque_late_s: float = 0.0
    bias_nm: float = 0.0
    creep_nm: float = 0.0
    creep_s: float = 50.0
    ramp_nm: float = 0.0
    wander_nm: float = 0.0
    hum_nm: float = 0.0
    hum_hz: float = 7.3
    bent_per_nm2: float = 0.0
    sign: float = 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording:
    """Samples that arrived: moments as they were and as stamped [s], position [rad], speed [rad/s], torque [N m]."""

    true_t: Array
    t: Array
    q: Array
    dq: Array
    torque: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class Clock:
    """Moments of all samples as they are and as they are stamped [s], and which samples arrive."""

    true_t: Array
    stamps: Array
    arrives: NDArray[np.bool_]


def clock_of(sensors: Sensors, duration_s: float, rng: np.random.Generator) -> Clock:
    """Ticks, read or stamped late, of which one to five at a time are lost."""
    ticks = np.arange(int((duration_s - 0.1) * sensors.rate_hz)) / sensors.rate_hz + 0.05
    late = np.minimum(rng.exponential(sensors.jitter_s, ticks.size), 0.8 / sensors.rate_hz)
    packets = np.minimum(np.arange(ticks.size) // 4 * 4 + 3, ticks.size - 1)
    true = ticks + late if sensors.clock == "late_samples" else ticks
    stamps = {"steady": ticks, "batches": ticks[packets] + 1e-4 * (np.arange(ticks.size) % 4)}
    arrives = np.ones(ticks.size, bool)
    for start in rng.integers(0, ticks.size, round(sensors.lost * ticks.size / 3)):
        arrives[start : start + rng.integers(1, 6)] = False
    return Clock(true_t=true, stamps=stamps.get(sensors.clock, ticks + late), arrives=arrives)


def coloured(n: int, step_s: float, sensors: Sensors, rng: np.random.Generator) -> Array:
    """Noise of the torque: autoregressive of order 1, its memory as long as the sensor's. [N m]"""
    stay = np.exp(-step_s / sensors.noise_memory_s)
    start = np.concatenate(([rng.normal()], rng.normal(size=n - 1) * np.sqrt(1 - stay**2)))
    return np.asarray(sensors.torque_noise_nm * lfilter([1.0], [1.0, -stay], start))


def read_torque(torque: Array, sensors: Sensors, rng: np.random.Generator) -> Array:
    """The torque as a sensor without noise would give it, in steps of STEP_S. [N m]"""
    t = np.arange(torque.size) * STEP_S
    read = np.interp(t - sensors.torque_late_s, t, torque)
    read += sensors.bias_nm + sensors.creep_nm * np.exp(-t / sensors.creep_s) + sensors.ramp_nm * t / t[-1]
    if sensors.wander_nm:
        walk = np.interp(t, np.linspace(0, t[-1], 200), np.cumsum(rng.normal(size=200)))
        read += sensors.wander_nm * (walk - walk.mean()) / walk.std()
    read += sensors.hum_nm * np.sin(2 * np.pi * sensors.hum_hz * t)
    return np.asarray(sensors.sign * (read + sensors.bent_per_nm2 * torque**3))


def logged_speed(q: Array, true_speed: Array, sensors: Sensors, rng: np.random.Generator) -> Array:
    """A tachometer's, or differences of the position behind two low-pass filters of the first order. [rad/s]"""
    if sensors.tachometer:
        return true_speed + rng.normal(size=q.size) * sensors.speed_noise_rad_s
    stay = np.exp(-2 * np.pi * sensors.difference_hz / sensors.rate_hz)
    once = lfilter([1 - stay], [1.0, -stay], np.diff(q, prepend=q[0]) * sensors.rate_hz)
    return np.asarray(lfilter([1 - stay], [1.0, -stay], once))


def record(
    theta: Array, omega: Array, torque: Array, sensors: Sensors, clock: Clock, rng: np.random.Generator
) -> Recording:
    """Motion and torque, in steps of STEP_S, as they are logged; ``torque`` is what ``read_torque`` gave."""
    fine, true_t = np.arange(theta.size) * STEP_S, clock.true_t
    count = 2 * np.pi / 2**sensors.encoder_bits
    q = np.round(np.interp(true_t, fine, theta) / count) * count
    noise = np.interp(true_t, fine[::5], coloured(fine[::5].size, 5 * STEP_S, sensors, rng))
    read = np.interp(true_t, fine, torque) + noise
    stepped = np.round(read / sensors.torque_step_nm) * sensors.torque_step_nm
    fresh = rng.random(q.size) >= sensors.repeated
    fresh[0] = True
    stepped = stepped[np.maximum.accumulate(np.where(fresh, np.arange(q.size), 0))]
    dq = logged_speed(q, np.interp(true_t, fine, omega), sensors, rng)
    kept = clock.arrives
    return Recording(true_t=true_t[kept], t=clock.stamps[kept], q=q[kept], dq=dq[kept], torque=stepped[kept])
