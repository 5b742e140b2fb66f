"""Sensor and recorder model: noise, quantisation, the channels of a log, lost samples, jitter of the time stamps."""

import hashlib
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float, Int, JointLog, Source
from friction_audit.simulation.effects.load_and_place import gravity_error_nm, ripple_reading_nm
from friction_audit.simulation.effects.sensors import TORQUE_LATE, VELOCITY_LATE, crosstalk_mixed, delayed
from friction_audit.simulation.settings import CONTROL_RATE_HZ, Moved, Sensors, SomeSettings, Streams, of_each_joint

Number = TypeVar("Number", float, Float)

STAMP_ROOM = 0.45  # a stamp errs by less than this share of the sampling interval, so that stamps keep their order
NANOSECONDS = 1e9  # clocks count whole nanoseconds
SCALE = 1e9  # inverse of the last place of a quantised value: finer than any resolution, coarser than rounding errors

EXTERNAL_CUTOFF_HZ = 100.0  # of the filter on ``tau_ext_hat_filtered``; an assumption, the vendor's is not published
EXTERNAL_STEP_NM = 1e-3  # resolutions as logged
GRAVITY_STEP_NM = 1e-6
TEMPERATURE_STEP_C = 0.1


def draw_noise(ticks: int, rate_hz: float, sensors: Sensors, rng: np.random.Generator) -> tuple[Float, Float, Float]:
    """Draw the sensor noise of torque, velocity and position of one joint, shape (ticks + 1,) each."""
    velocity = sensors.velocity_noise_rad_s * rng.normal(0.0, 1.0, ticks + 1)
    # A fast and a slow first-order autoregressive process, together of the variance of the noise.
    share = sensors.slow_noise_share
    fast = _autoregressive(rng.normal(0.0, 1.0, ticks + 1), rate_hz, sensors.torque_correlation_s)
    slow = _autoregressive(rng.normal(0.0, 1.0, ticks + 1), rate_hz, sensors.slow_correlation_s)
    torque = np.asarray(sensors.torque_noise_nm * (np.sqrt(1.0 - share) * fast + np.sqrt(share) * slow))
    return torque, velocity, sensors.position_noise_rad * rng.normal(0.0, 1.0, ticks + 1)


def _autoregressive(noise: Float, rate_hz: float, correlation_s: float) -> Float:
    """Turn white noise of unit variance into first-order autoregressive noise of unit variance."""
    if correlation_s == 0:
        return noise
    keep = np.exp(-1.0 / (rate_hz * correlation_s))
    gain = np.sqrt((1.0 + keep) / (1.0 - keep))
    return np.asarray(gain * _low_pass(noise, keep, gain))


def _low_pass(signal: Float, keep: float, gain: float = 1.0) -> Float:
    """Apply the recursion y[k] = keep y[k-1] + (1 - keep) x[k] to columns, beginning at the first value over a gain."""
    from scipy.signal import lfilter

    smoothed, _ = lfilter([1.0 - keep], [1.0, -keep], signal, axis=0, zi=keep * (signal[:1] / gain))
    return np.asarray(smoothed)


@compiled()
def quantised(step: float, value: Number) -> Number:
    """Round to multiples of a step; a step of 0 changes nothing."""
    return value if step == 0.0 else np.rint(np.rint(value / step) * step * SCALE) / SCALE


quantise: Callable[[float, Float], Float] = quantised.py_func  # type: ignore[attr-defined]  # the same of an array


def read_log(settings: SomeSettings, moved: Moved, streams: Streams, path: str) -> JointLog:
    """Return the log of a motion: the states that were kept, with the stamps of the recorder."""
    channels = _channels(settings, moved)
    samples = int((len(channels["q"]) - 1) * settings.rate_hz / CONTROL_RATE_HZ + 1e-9)
    ticks = np.rint(np.arange(samples + 1) * (CONTROL_RATE_HZ / settings.rate_hz)).astype(np.int64)
    t, kept = record(ticks / CONTROL_RATE_HZ, settings.rate_hz, settings.sensors[0], streams.recorder)
    # Sensors know one zero: adding 0 turns the negative one, which text would show, into it.
    columns = {name: np.asfortranarray(channel[ticks[kept]] + 0.0) for name, channel in channels.items()}
    digest = hashlib.sha256(t.tobytes())
    for column in columns.values():
        digest.update(column.tobytes(order="F"))
    source = Source(path=path, sha256=digest.hexdigest(), format="simulation", robot=settings.robot, clock="robot_time")
    names = tuple(f"panda_joint{k}" for k in range(1, 8)) if settings.robot == "panda" else ("joint1",)
    return JointLog(t=t, **columns, joint_names=names, source=source)


def _channels(settings: SomeSettings, moved: Moved) -> dict[str, Float]:
    """Return what is logged at every tick, shape (n + 1, j): of an arm the torque at its sensors, gravity in it."""
    motion, hidden, gravity = moved.motion, settings.hidden, moved.gravity
    error = _by_joint(gravity_error_nm, [inside.gravity_error for inside in hidden], motion.q)
    q, dq, port = _sense(settings, moved, error if gravity is None else np.zeros_like(error))
    channels = {"q": q, "dq": dq}
    if gravity is None:
        channels["tau_interaction"] = port
    else:
        tau_J, logged = port if settings.driven else -port, gravity + error
        # First order, causal, settled at the first value, as a vendor's controller filters.
        keep = np.exp(-2.0 * np.pi * EXTERNAL_CUTOFF_HZ / CONTROL_RATE_HZ)
        channels["tau_J"] = tau_J
        channels["tau_ext_hat_filtered"] = quantise(EXTERNAL_STEP_NM, _low_pass(tau_J - logged, keep))
        channels["gravity"] = quantise(GRAVITY_STEP_NM, logged)
    if settings.compensator is not None:
        channels["tau_compensation"] = motion.compensation_nm
        if any(one is not None and one.passivity for one in of_each_joint(settings.compensator, len(hidden))):
            channels["tau_passivity"] = motion.passivity_nm
    if settings.robot == "panda" and not settings.driven:
        channels["tau_J_d"] = motion.compensation_nm + motion.passivity_nm
    if settings.logs_temperature:
        cold, rise = np.array([(inside.warm_up.cold_c, inside.warm_up.rise_k) for inside in hidden]).T
        channels["temperature"] = quantise(TEMPERATURE_STEP_C, cold + rise * motion.warmth)
    return channels


def _sense(settings: SomeSettings, moved: Moved, error: Float) -> tuple[Float, Float, Float]:
    """Return position, velocity and interaction torque as read, which has an ``error`` before it is rounded."""
    hidden, sensors, motion, loop = settings.hidden, settings.sensors, moved.motion, moved.loop
    torque_late, motion_late = (
        [one.time_delay.delay_s if one.time_delay.form == form else 0.0 for one in hidden]
        for form in (TORQUE_LATE, VELOCITY_LATE)
    )
    port = _by_joint(delayed, torque_late, motion.port_nm)
    port = crosstalk_mixed([inside.torque_crosstalk for inside in hidden], port)
    ripple = _by_joint(ripple_reading_nm, [inside.torque_ripple for inside in hidden], motion.q)
    torque = port + ripple + loop.torque_noise + error
    position = _by_joint(delayed, motion_late, motion.q) + loop.position_noise
    velocity = _by_joint(delayed, motion_late, motion.dq) + loop.velocity_noise
    return (
        _by_joint(quantise, [one.position_step_rad for one in sensors], position),
        _by_joint(quantise, [one.velocity_step_rad_s for one in sensors], velocity),
        _by_joint(quantise, [one.torque_step_nm for one in sensors], torque),
    )


def _by_joint(function: Callable[[Any, Float], Float], of: Sequence[object], signals: Float) -> Float:
    """Apply a function to what each joint has of something and to its column."""
    return np.column_stack([function(one, column) for one, column in zip(of, signals.T, strict=True)])


def record(times: Float, rate_hz: float, sensors: Sensors, rng: np.random.Generator) -> tuple[Float, Int]:
    """Draw lost samples, stale samples and the jitter of the stamps for the states at the given times.

    Returns stamps from 0, strictly increasing [s], and which of the states each sample holds, shape (m,) each.
    """
    # One long burst is lost, the others one by one; the ends are kept.
    lost = np.zeros(len(times), dtype=np.bool_)
    count = min(round(sensors.lost * len(times)), len(times) - 2)
    burst = min(sensors.longest_loss, count)
    lost[1 + rng.choice(len(times) - 2, count - burst, replace=False)] = True
    first = rng.integers(1, len(times) - burst)
    lost[first : first + burst] = True
    kept = np.flatnonzero(~lost)
    stale = rng.random(len(kept)) < sensors.stale
    stale[0] = False
    source = np.maximum.accumulate(np.where(stale, 0, np.arange(len(kept))))
    room = STAMP_ROOM / rate_hz
    jitter = np.clip(rng.normal(0.0, sensors.clock_jitter_s / np.sqrt(2.0), len(kept)), -room, room)
    nanoseconds = np.rint((times[kept] + jitter) * NANOSECONDS).astype(np.int64)
    return (nanoseconds - nanoseconds[0]) / NANOSECONDS, kept[source]
