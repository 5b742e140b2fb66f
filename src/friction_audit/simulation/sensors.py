"""What the sensors and the recorder make of the truth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.simulation.settings import Sensors

STAMP_ROOM = 0.45
"""A stamp errs by less than this share of the sampling interval, so that stamps keep their order."""

NANOSECONDS = 1e9
"""Clocks count whole nanoseconds."""

BINARY_NOISE_DIGITS = 9
"""Decimal places kept of a quantised value: finer than any resolution, coarser than rounding errors."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class SensorNoise:
    """What the sensors of one joint add to the truth, drawn before the motion; n + 1 ticks.

    A sensor reads ``quantise(truth + noise, step)``: a compensator in the loop can thus be given what the log shows.

    Attributes:
        torque: Shape (n + 1,). [N m]
        velocity: Shape (n + 1,). [rad/s]
        position: Shape (n + 1,). [rad]
    """

    torque: Float
    velocity: Float
    position: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Recorder:
    """Which states were recorded, and when; m samples.

    Attributes:
        t: Stamps from 0, strictly increasing, shape (m,). [s]
        tick: Which of the states each sample holds, shape (m,).
    """

    t: Float
    tick: NDArray[np.int64]


def record(times: Float, rate_hz: float, sensors: Sensors, rng: np.random.Generator) -> Recorder:
    """Draw lost samples, stale samples and the jitter of the stamps for the states at the given times."""
    kept = np.flatnonzero(~_lost(len(times), sensors, rng))
    stale = rng.random(len(kept)) < sensors.stale
    stale[0] = False
    source = np.maximum.accumulate(np.where(stale, 0, np.arange(len(kept))))
    stamps = times[kept]
    if sensors.clock_jitter_s > 0:
        room = STAMP_ROOM / rate_hz
        stamps = stamps + np.clip(rng.normal(0.0, sensors.clock_jitter_s / np.sqrt(2.0), len(kept)), -room, room)
    nanoseconds = np.rint(stamps * NANOSECONDS).astype(np.int64)
    return Recorder(t=(nanoseconds - nanoseconds[0]) / NANOSECONDS, tick=kept[source])


def _lost(samples: int, sensors: Sensors, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Mark the samples that were never recorded: one long burst, the others one by one; the ends are kept."""
    lost = np.zeros(samples, dtype=np.bool_)
    count = min(round(sensors.lost * samples), samples - 2)
    burst = min(sensors.longest_loss, count)
    lost[1 + rng.choice(samples - 2, count - burst, replace=False)] = True
    first = rng.integers(1, samples - burst)
    lost[first : first + burst] = True
    return lost


def draw_noise(ticks: int, rate_hz: float, sensors: Sensors, rng: np.random.Generator) -> SensorNoise:
    """Draw the noise of one joint's sensors for ticks + 1 states; zeros where they are ideal."""
    velocity = sensors.velocity_noise_rad_s * rng.normal(0.0, 1.0, ticks + 1)
    torque = _torque_noise(ticks + 1, rate_hz, sensors, rng)
    position = sensors.position_noise_rad * rng.normal(0.0, 1.0, ticks + 1)
    return SensorNoise(torque=torque, velocity=velocity, position=position)


def _torque_noise(samples: int, rate_hz: float, sensors: Sensors, rng: np.random.Generator) -> Float:
    """Draw a fast and a slow first-order autoregressive process, together of the variance of the noise."""
    share = sensors.slow_noise_share
    fast = _colour(rng.normal(0.0, 1.0, samples), rate_hz, sensors.torque_correlation_s)
    slow = _colour(rng.normal(0.0, 1.0, samples), rate_hz, sensors.slow_correlation_s)
    return np.asarray(sensors.torque_noise_nm * (np.sqrt(1.0 - share) * fast + np.sqrt(share) * slow))


def _colour(noise: Float, rate_hz: float, correlation_s: float) -> Float:
    """Turn white noise of unit variance into first-order autoregressive noise of unit variance."""
    if correlation_s == 0:
        return noise
    keep = np.exp(-1.0 / (rate_hz * correlation_s))
    gain = np.sqrt((1.0 + keep) / (1.0 - keep))
    return np.asarray(gain * _smooth(noise, keep, noise[0] / gain))


def quantise(signal: Float, step: float) -> Float:
    """Round to multiples of a step; a step of 0 changes nothing. ``mechanics.sensing`` has the same for one value."""
    if step == 0:
        return signal
    return np.round(np.rint(signal / step) * step, BINARY_NOISE_DIGITS)


def low_pass(signal: Float, cutoff_hz: float, rate_hz: float) -> Float:
    """Filter as a vendor's controller does: first order, causal, settled at the first value."""
    return _smooth(signal, np.exp(-2.0 * np.pi * cutoff_hz / rate_hz), signal[0])


def _smooth(signal: Float, keep: float, start: float) -> Float:
    """Apply the first-order recursion y[k] = keep y[k-1] + (1 - keep) x[k], beginning at ``start``."""
    from scipy.signal import lfilter

    smoothed, _ = lfilter([1.0 - keep], [1.0, -keep], signal, zi=[keep * start])
    return np.asarray(smoothed)
