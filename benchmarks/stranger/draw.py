"""Seed and names of effects -> a joint that moves, hides them at a given size, and is recorded."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import butter, sosfiltfilt

from benchmarks.stranger.effects import HIDDEN, OUTSIDE, RECORDED, Setup
from benchmarks.stranger.joint import STEP_S, Drive, Joint, integrate, known_load
from benchmarks.stranger.motions import MOTIONS, tremor
from benchmarks.stranger.sensors import Recording, Sensors, clock_of, coloured, read_torque, record

Array = NDArray[np.float64]
SIZES = (0.3, 0.5, 1.0, 3.0)
"""Partial sizes rho: rms of what an effect adds, free of the declared columns, over the noise rms below 20 Hz."""
SLOW_HZ = 20.0
TOLERANCE = 0.03
SHOULDER_AND_ELBOW = 4
"""Joints of an arm before its wrist."""
EVERY = round(0.01 / STEP_S)


@dataclass(frozen=True, eq=False, kw_only=True)
class Moved:
    """A motion without sensors, in steps of STEP_S: position [rad], speed [rad/s], torque as read [N m]."""

    theta: Array
    omega: Array
    torque: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class Case:
    """A recording of one joint, and all that is true of it."""

    seed: int
    joint: int
    names: tuple[str, ...]
    motion: str
    hand: bool
    size: float
    reached: tuple[float, ...]
    strengths: tuple[float, ...]
    setup: Setup
    recording: Recording
    load: Array


def draw_setup(seed: int, joint: int) -> Setup:
    """A joint of an arm and its sensors; those of the wrist are lighter, and their sensors finer. One clock for all."""
    common, rng = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 10, joint])
    wrist = joint > SHOULDER_AND_ELBOW
    made = Joint(
        inertia=float(np.exp(rng.uniform(np.log(0.06), np.log(0.2))) * (1 if wrist else 3)),
        coulomb=rng.uniform(0.15, 0.5),
        viscous=rng.uniform(0.03, 0.1),
    )
    sensors = Sensors(
        rate_hz=float(common.choice([500.0, 1000.0])),
        clock=str(common.choice(["steady", "late_stamps", "late_samples"])),
        lost=common.uniform(0.01, 0.03),
        torque_noise_nm=rng.uniform(0.024, 0.036) if wrist else rng.uniform(0.045, 0.06),
        noise_memory_s=float(np.exp(rng.uniform(np.log(0.01), np.log(0.1)))),
        torque_step_nm=0.006 if wrist else 0.0357,
        encoder_bits=int(rng.integers(15, 21)),
        repeated=rng.uniform(0.0, 0.19),
    )
    return Setup(joint=made, sensors=sensors, duration_s=float(common.uniform(60, 120)))


def drive_of(joint: Joint, rng: np.random.Generator, *, hand: bool) -> Drive:
    """A hand is soft; a motor follows firmly, and knows the inertia."""
    rate = 2 * np.pi * (rng.uniform(1.2, 2.5) if hand else rng.uniform(5.0, 8.0))
    return Drive(joint.inertia * rate**2, 1.6 * rate * joint.inertia, 0.0 if hand else 1.0, -1.0 if hand else 1.0)


def moved(setup: Setup, drive: Drive, wanted: Array, grip: Array, rng: np.random.Generator) -> Moved:
    """The motion of a joint, and its torque as a noiseless sensor reads it."""
    theta, omega, driven, sprung = integrate(setup.joint, drive, wanted, grip)
    torque = sprung if setup.torque_at == "spring" else driven
    return Moved(theta=theta, omega=omega, torque=read_torque(torque, setup.sensors, rng))


def slow(values: Array, step_s: float = STEP_S) -> Array:
    """What is below SLOW_HZ."""
    return np.asarray(sosfiltfilt(butter(4, SLOW_HZ, fs=1 / step_s, output="sos"), values))


def near_sticking(omega: Array) -> NDArray[np.bool_]:
    """Where the filter of ``slow`` mixes in moments at which the joint stuck for 5 ms or longer."""
    stuck = minimum_filter1d((np.abs(omega) < 2e-3).astype(np.uint8), round(0.005 / STEP_S))
    return np.asarray(maximum_filter1d(stuck, round(0.1 / STEP_S)) > 0)


def missing_rms(motion: Moved, declared_inertia: float | None) -> float:
    """Rms of the slow torque that inertia, Coulomb and viscous friction leave while the joint moves. [N m]"""
    torque, speed = slow(motion.torque)[::EVERY], slow(motion.omega)
    acceleration = np.gradient(speed, STEP_S)[::EVERY]
    columns = [slow(np.tanh(motion.omega / 1e-3))[::EVERY], speed[::EVERY]]
    if declared_inertia is None:
        columns.append(acceleration)
    else:
        torque = torque - declared_inertia * acceleration
    moving = (np.abs(speed) > 0.03)[::EVERY] & ~near_sticking(motion.omega)[::EVERY]
    matrix = np.column_stack(columns)[moving]
    left = torque[moving] - matrix @ np.linalg.lstsq(matrix, torque[moving])[0]
    return float(np.sqrt(np.mean(left**2)))


def draw_motion(
    setup: Setup, seed: int, joint: int
) -> tuple[str, bool, tuple[Drive, NDArray[np.float64], NDArray[np.float64]]]:
    """Name of a motion, whether a hand makes it, and the drive with where it goes and how firmly it holds."""
    common, rng = np.random.default_rng([seed, 1]), np.random.default_rng([seed, 11, joint])
    hand = bool(common.random() < 0.5)
    name = str(rng.choice(["reaches", "reaches", "spline", "multisine"] if hand else [*MOTIONS]))
    drive = drive_of(setup.joint, rng, hand=hand)
    wanted, grip = MOTIONS[name](rng, setup.duration_s)
    wanted = wanted + rng.uniform(-0.5, 0.5) + (tremor(rng, wanted.size) if hand else 0.0)
    return name, hand, (drive, wanted, grip)


def draw_case(
    seed: int, names: Sequence[str], size: float, *, joint: int = 1, duration_s: float | None = None
) -> Case | None:
    """A recording that hides each of the named effects at this size; None where no strength reaches it.

    Joints of one seed are recorded by one clock, and are moved all by hand or all by motors.
    """
    setup = draw_setup(seed, joint)
    setup = setup if duration_s is None else replace(setup, duration_s=duration_s)
    motion, hand, driven = draw_motion(setup, seed, joint)
    noise = coloured(round(setup.duration_s * 1000), 1e-3, setup.sensors, np.random.default_rng([seed, 12, joint]))
    slow_noise = float(slow(noise, 1e-3).std())
    found = [(0.0, 0.0) if n in RECORDED else strength_for(setup, n, seed, size * slow_noise, driven) for n in names]
    reached = [one for one in found if one is not None]
    if len(reached) < len(names):
        return None
    for name, (strength, _) in zip(names, reached, strict=True):
        setup = put(setup, name, strength, seed)
    made = moved(setup, *driven, np.random.default_rng([seed, 2]))
    clock = clock_of(setup.sensors, setup.duration_s, np.random.default_rng([seed, 3]))
    rng = np.random.default_rng([seed, 13, joint])
    recording = record(made.theta, made.omega, made.torque, setup.sensors, clock, rng)
    load = np.array([known_load(setup.joint, q, t) for q, t in zip(recording.q, recording.true_t, strict=True)])
    return Case(
        seed=seed, joint=joint, names=tuple(names), motion=motion, hand=hand, size=size,
        reached=tuple(rms / slow_noise for _, rms in reached), strengths=tuple(s for s, _ in reached),
        setup=setup, recording=recording, load=load,
    )  # fmt: skip


def put(setup: Setup, name: str, strength: float, seed: int) -> Setup:
    """The setup with an effect; what is drawn of it does not depend on its strength."""
    rng = np.random.default_rng([seed, 4])
    if name in RECORDED:
        return RECORDED[name](setup, rng)
    return {**HIDDEN, **OUTSIDE}[name][0](setup, strength, rng)


def strength_for(
    setup: Setup, name: str, seed: int, wanted_rms: float, motion: tuple[Drive, Array, Array]
) -> tuple[float, float] | None:
    """Strength at which an effect alone has this rms, and the rms it then has, by a secant of the logarithms."""
    strength = {**HIDDEN, **OUTSIDE}[name][1]
    tried: list[tuple[float, float]] = []
    power = 1.0
    for _ in range(8):
        changed = put(setup, name, strength, seed)
        made = moved(changed, *motion, np.random.default_rng([seed, 2]))
        rms = missing_rms(made, changed.declared_inertia) if np.isfinite(made.theta).all() else np.nan
        if not rms > 0.0 or np.mean(np.abs(made.omega) > 0.2) < 0.1:
            return None
        if abs(rms / wanted_rms - 1) < TOLERANCE:
            return strength, rms
        tried.append((np.log(strength), np.log(rms)))
        if len(tried) > 1 and abs(tried[-1][0] - tried[-2][0]) > 1e-9:
            slope = (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
            power = float(np.clip(slope, 0.3, 3.0)) if np.isfinite(slope) else power
        strength *= float(np.clip((wanted_rms / rms) ** (1 / power), 0.05, 20.0))
    return (strength, rms) if abs(rms / wanted_rms - 1) < 0.25 else None
