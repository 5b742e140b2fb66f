"""Whole arms of 6 or 7 joints: rigid-body torque of MuJoCo, friction and one hidden effect by formulas of this file.

The arms are like a UR10 and an iiwa; masses, friction and sensors differ from log to log. One joint moves after the
other, all go from point to point, follow sines, or move slowly and then fast. No model of the arm is given to the
detector: `inertial_coupling` is true of all joints, `gravity_error` of those that bear a weight.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numba import njit
from numpy.random import Generator
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, lfilter, sosfilt
from scipy.spatial.transform import Rotation
from scipy.special import erf

from benchmarks.answers import ANSWER, answer_of, truth_of
from benchmarks.resume import Job, Row
from friction_audit.api import diagnose_log, log_from_frame

KEYS = ("log", "truth", "seed")
FIELDS = (*KEYS, "scenario", "size", "joint", "hidden_here", "also", *ANSWER)
HIDDEN = ("stribeck", "asymmetric_coulomb", "torque_ripple", "nonlinear_viscous", "friction_step",
          "load_dependent_friction", "presliding", "time_delay")  # fmt: skip
SIZES = (0.3, 0.6)  # root mean square of the torque of an effect over the Coulomb friction
FINE_HZ = 1000.0
Frame = dict[str, np.ndarray]
Vector = tuple[float, float, float]


class Link(NamedTuple):
    """A link with its joint, in the frame of the link before."""

    place: Vector  # of the joint [m]
    axis: Vector
    mass: float  # [kg]
    centre: Vector  # of mass [m]
    box: Vector  # sides of one of the same inertia [m]
    coulomb: float  # [N m]
    rotor: float  # [kg m^2]
    middle: float  # of the motion [rad]
    reach: float  # to both sides [rad]


UR = (
    Link((0, 0, 0.163), (0, 0, 1), 3.8, (0, -0.02, 0), (0.12, 0.12, 0.15), 9.0, 1.6, 0.0, 1.6),
    Link((0, 0.138, 0), (0, 1, 0), 8.4, (0.21, 0, 0), (0.45, 0.10, 0.10), 11.0, 1.6, -1.2, 0.8),
    Link((0.425, -0.131, 0), (0, 1, 0), 2.4, (0.16, 0, 0), (0.40, 0.09, 0.09), 7.0, 1.2, 1.2, 1.1),
    Link((0.392, 0, 0), (0, 1, 0), 1.3, (0, 0.11, 0.01), (0.07, 0.07, 0.12), 3.0, 0.35, -0.9, 1.2),
    Link((0, 0.127, 0), (0, 0, -1), 1.3, (0, 0, -0.09), (0.07, 0.07, 0.12), 2.8, 0.35, -1.2, 1.2),
    Link((0, 0, -0.1), (0, 1, 0), 1.6, (0.03, 0.12, 0.02), (0.09, 0.09, 0.16), 2.5, 0.30, 0.0, 2.0),
)
IIWA = (
    Link((0, 0, 0.16), (0, 0, 1), 4.2, (0, -0.03, 0.12), (0.12, 0.12, 0.25), 8.0, 1.8, 0.0, 1.6),
    Link((0, 0, 0.20), (0, 1, 0), 4.1, (0.01, 0.05, 0.09), (0.12, 0.12, 0.25), 10.0, 1.8, 0.6, 0.9),
    Link((0, 0, 0.20), (0, 0, 1), 3.1, (0, 0.03, 0.13), (0.10, 0.10, 0.22), 6.0, 1.0, 0.0, 1.4),
    Link((0, 0, 0.22), (0, -1, 0), 2.8, (0, 0.06, 0.08), (0.10, 0.10, 0.22), 6.0, 0.9, -1.3, 0.7),
    Link((0, 0, 0.18), (0, 0, 1), 1.8, (0.01, 0.02, 0.08), (0.09, 0.09, 0.18), 3.5, 0.5, 0.0, 1.6),
    Link((0, 0, 0.22), (0, 1, 0), 1.8, (0, 0.01, 0.02), (0.09, 0.09, 0.12), 2.8, 0.3, 1.0, 1.0),
    Link((0, 0, 0.09), (0, 0, 1), 2.2, (0.03, 0.01, 0.10), (0.09, 0.09, 0.12), 2.2, 0.2, 0.0, 2.0),
)
ARMS = {"ur": UR, "iiwa": IIWA}


def model_of(arm: Sequence[Link], rng: Generator) -> mujoco.MjModel:
    """An arm whose masses, centres of mass, inertias and rotors are off from the table by up to 30 %."""
    spec = mujoco.MjSpec()
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    body = spec.worldbody
    for link in arm:
        mass = link.mass * rng.uniform(0.7, 1.3)
        # Second moments about planes: no inertia of a body is larger than the sum of the others.
        second = mass * np.square(link.box) / 12 * rng.uniform(0.8, 1.2) * rng.uniform(0.95, 1.05, 3)
        x, y, z, w = Rotation.from_rotvec(rng.uniform(-0.25, 0.25, 3)).as_quat()
        body = body.add_body(pos=link.place, mass=mass, ipos=np.array(link.centre) * rng.uniform(0.7, 1.3, 3),
                             inertia=second.sum() - second, iquat=[w, x, y, z], explicitinertial=True)  # fmt: skip
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=link.axis, armature=link.rotor * rng.uniform(0.7, 1.3))
    return spec.compile()


def rigid_torque(model: mujoco.MjModel, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
    """Torque that moves an arm without friction, shape (n, joints). [N m]"""
    data, torque = mujoco.MjData(model), np.empty_like(q)
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], dq[k], ddq[k]
        mujoco.mj_inverse(model, data)
        torque[k] = data.qfrc_inverse
    return torque


def _log_uniform(rng: Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


class Part(NamedTuple):
    """A part of a motion: seconds; longest way over the reach; peak speeds [rad/s]; seconds of a way and of a pause."""

    seconds: tuple[float, float]
    far: float
    peak: tuple[float, float]
    lasts: tuple[float, float]
    pauses: tuple[float, ...]


ALONE = Part((11.0, 11.0), 0.6, (0.08, 1.5), (0.4, 5.0), (0.0, 0.3))
POINTS = Part((70.0, 120.0), 2.0, (0.4, 2.0), (0.6, 20.0), (0.0, 0.3, 0.6))
SLOW = Part((60.0, 80.0), 0.35, (0.038, 0.38), (1.0, 8.0), (0.0, 0.4))
FAST = Part((30.0, 30.0), 2.0, (1.0, 2.5), (0.5, 20.0), (0.0, 0.3))
MOTIONS = ("one", "points", "sines", "slow")


def legs(middle: np.ndarray, reach: np.ndarray, kind: str, rng: Generator) -> Iterator[tuple[np.ndarray, float, float]]:
    """Poses to go to, shape (joints,) [rad], seconds of the way and of the pause; "one": each joint alone, twice."""
    at, every, low, high = middle, np.arange(len(middle)), middle - reach, middle + reach
    turns = [(ALONE, np.array([j])) for _ in range(2) for j in rng.permutation(every)]
    for part, moved in {"one": turns, "points": [(POINTS, every)], "slow": [(SLOW, every), (FAST, every)]}[kind]:
        if part is ALONE:
            at = rng.uniform(low, high)
            yield at, 2.5, 0.3
        home, left = at, rng.uniform(*part.seconds)
        while left > 0:
            about, far, goal = home if part is ALONE else at, part.far * reach, at.copy()
            goal[moved] = rng.uniform(np.maximum(low, about - far), np.minimum(high, about + far))[moved]
            way, pause = np.max(np.abs(goal - at)), float(rng.choice(part.pauses))
            seconds = float(np.clip(1.88 * way / _log_uniform(rng, *part.peak), *part.lasts))
            yield goal, seconds, pause
            at, left = goal, left - seconds - pause


def sines(middle: np.ndarray, reach: np.ndarray, rng: Generator) -> np.ndarray:
    """Three to five sines in each joint, from rest to rest, shape (n, joints). [rad]"""
    t = np.arange(round(rng.uniform(60.0, 120.0) * FINE_HZ))[:, None] / FINE_HZ
    joints, q = len(reach), np.zeros_like(t)
    sizes = rng.uniform(0.3, 1.0, (5, joints)) * (np.arange(5)[:, None] < rng.integers(3, 6, joints))
    for size in 0.9 * reach * sizes / sizes.sum(axis=0):
        q = q + size * np.sin(2 * np.pi * (rng.uniform(0.03, 0.35, joints) * t + rng.random(joints)))
    x = np.clip(np.minimum(t, t[-1] - t) / 2.0, 0.0, 1.0)
    return np.asarray(middle + x**3 * (10 - 15 * x + 6 * x * x) * q)


def motion(arm: Sequence[Link], kind: str, rng: Generator) -> np.ndarray:
    """Positions of a controller that smooths steps of the acceleration over 20 ms, shape (n, joints). [rad]"""
    middle, reach = np.array([(link.middle, link.reach) for link in arm]).T
    if kind == "sines":
        q = sines(middle, reach, rng)
    else:
        at, pieces, quintic, ramp = middle, [], rng.random() < 0.5, rng.uniform(0.15, 0.4)
        for goal, seconds, pause in legs(middle, reach, kind, rng):
            x = np.linspace(0.0, 1.0, round(seconds * FINE_HZ))
            speed = x**2 * (1 - x) ** 2 if quintic else np.interp(x, [0.0, ramp, 1 - ramp, 1.0], [0.0, 1.0, 1.0, 0.0])
            pieces += [at + np.outer(np.cumsum(speed) / speed.sum(), goal - at),
                       np.tile(goal, (round(pause * FINE_HZ), 1))]  # fmt: skip
            at = goal
        q = np.concatenate(pieces)
    return np.asarray(uniform_filter1d(np.pad(q, ((500, 500), (0, 0)), mode="edge"), 20, axis=0))


@njit(cache=True)
def _dahl(q: np.ndarray, reach: float) -> np.ndarray:
    """Friction of Dahl's model over the Coulomb friction, exact while the direction stays, shape (n,). [1]"""
    z = np.zeros_like(q)
    for k in range(1, len(q)):
        step = q[k] - q[k - 1]
        side = np.sign(step)
        z[k] = side + (z[k - 1] - side) * np.exp(-abs(step) / reach)
    return z


def hidden_torque(truth: str, size: float, joint: Sequence[np.ndarray], coulomb: float, rng: Generator) -> np.ndarray:
    """What an effect adds to t, q, dq, smoothed sign, rigid-body torque and friction of a joint, shape (n,). [N m]"""
    t, q, dq, sign, load, friction = joint
    speed = np.abs(dq)
    if truth == "time_delay":
        return np.asarray(np.interp(t - 0.02 * size, t, load + friction) - load - friction)
    if truth == "presliding":
        return np.asarray(coulomb * (_dahl(q, 0.03 * size) - sign))
    shape = {
        "stribeck": np.exp(-((speed / _log_uniform(rng, 0.02, 0.15)) ** rng.choice([1.0, 2.0]))) * sign,
        "asymmetric_coulomb": np.abs(sign) * rng.choice([-1.0, 1.0]),
        "torque_ripple": np.sin(rng.uniform(12.0, 60.0) * q + rng.uniform(0.0, 2 * np.pi)),
        "nonlinear_viscous": rng.choice(np.array([dq * speed, np.arcsinh(10.0 * dq)])),
        "friction_step": friction * (t > t[-1] * rng.uniform(0.35, 0.65)),
        "load_dependent_friction": np.abs(load) * sign,
    }[truth]
    scale = size / np.sqrt(np.mean(shape[speed > 5e-3] ** 2))
    return np.asarray(coulomb * shape * (min(scale, 1.2) if truth == "stribeck" else scale))


def recorded(signals: Sequence[np.ndarray], coulomb: np.ndarray, rng: Generator) -> tuple[Frame, str]:
    """Columns of a log of t, q, dq and torque, with noise of 1 to 5 % of the Coulomb friction; its sensors in words."""
    rate, noise = float(rng.choice([100.0, 125.0, 250.0, 500.0, 1000.0])), str(rng.choice(["white", "ar1", "current"]))
    t, q, dq, torque = (signal[:: round(FINE_HZ / rate)] for signal in signals)
    level, white = coulomb * _log_uniform(rng, 0.01, 0.05), rng.normal(size=torque.shape)
    pole = np.exp(-1.0 / (rate * 0.02)) if noise == "ar1" else 0.0
    torque = torque + level * lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], white, axis=0)
    if noise == "current":  # in steps
        torque = np.round(torque / level) * level
    bits = int(rng.integers(16, 21))
    frame = {"t": t, "q": np.round(q * 2.0**bits / (2 * np.pi)) * (2 * np.pi) / 2.0**bits, "tau_J": torque}
    if rng.random() < 0.6:
        frame["dq"] = dq + rng.normal(size=dq.shape) * 2e-3
        if rng.random() < 0.5:
            low = butter(2, min(0.2 * rate, 40.0), fs=rate, output="sos")
            frame["dq"] = np.asarray(sosfilt(low, frame["dq"], axis=0))
    return frame, f"{rate:.0f} Hz, {bits} bit, {noise} noise, {'dq' if 'dq' in frame else 'no dq'}"


def log_of(name: str, truth: str, size: float, seed: int) -> tuple[Frame, str, Sequence[Row]]:
    """Columns of a log, how it was made in words, and whether each joint hides the effect and what else is true."""
    kind, way = name.split()
    draws = [seed, list(ARMS).index(kind), MOTIONS.index(way), ("none", *HIDDEN).index(truth)]
    rng, arm = np.random.default_rng(draws), ARMS[kind]
    model, q = model_of(arm, rng), motion(arm, way, rng)
    dq = np.asarray(np.gradient(q, 1 / FINE_HZ, axis=0))
    load = rigid_torque(model, q, dq, np.asarray(np.gradient(dq, 1 / FINE_HZ, axis=0)))
    still = np.zeros_like(q[::100])
    heavy = np.std(rigid_torque(model, q[::100], still, still), axis=0) > 0.02
    table, width = np.array([link.coulomb for link in arm]), _log_uniform(rng, 1e-3, 1e-2)
    coulomb, viscous = table * rng.uniform(0.7, 1.35, len(table)), table * rng.uniform(0.3, 1.2, len(table))
    law = str(rng.choice(["algebraic", "erf"]))
    sign = dq / np.sqrt(dq**2 + width**2) if law == "algebraic" else erf(np.sqrt(np.pi) / 2 * dq / width)
    t, friction, hidden = np.arange(len(q)) / FINE_HZ, coulomb * sign + viscous * dq, int(rng.integers(len(table)))
    torque = load + friction
    if truth != "none":
        joint = (t, *(signal[:, hidden] for signal in (q, dq, sign, load, friction)))
        torque[:, hidden] += hidden_torque(truth, size, joint, coulomb[hidden], rng)
    frame, sensors = recorded((t, q, dq, torque), coulomb, rng)
    known = [{"hidden_here": str(truth != "none" and j == hidden),
              "also": "inertial_coupling;gravity_error" if heavy[j] else "inertial_coupling"}
             for j in range(len(table))]  # fmt: skip
    return frame, f"{law} {1e3 * width:.1f} mrad/s, {sensors}", known


def run_one(task: Row) -> list[dict[str, object]]:
    """The rows of a log; ``also``: what is true of a joint besides the hidden effect."""
    frame, scenario, known = log_of(task["log"], task["truth"], float(task["size"]), int(task["seed"]))
    found = diagnose_log(log_from_frame(frame)).joints
    row = {**task, "scenario": scenario}
    return [{**row, "joint": one.joint, **known[one.joint - 1], **answer_of(one)} for one in found]


def judged(row: Row) -> Row:
    """A row without the names that are true of its joint with anything hidden in it."""
    also, own = set(row["also"].split(";")), truth_of(row)
    names = ((one, set(one.split("|"))) for one in row["sets"].split(";"))
    return {**row, "sets": ";".join(one for one, given in names if given & own or not given & also)}


def job(seeds: Sequence[int]) -> Job:
    """Diagnose arms of some seeds: each arm and motion with nothing hidden, each effect in an arm and motion by lot."""
    names, wanted = [f"{arm} {way}" for arm in ARMS for way in MOTIONS], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        cases = [(name, "none", "0") for name in names]
        cases += [(str(rng.choice(names)), truth, str(rng.choice(SIZES))) for truth in HIDDEN]
        wanted += [{"log": log, "truth": truth, "size": size, "seed": str(seed)} for log, truth, size in cases]
    return Job(FIELDS, wanted, run_one, KEYS)
