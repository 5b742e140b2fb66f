"""Joints whose torque holds gravity: B ddq + Fc dq / sqrt(dq^2 + w^2) + Fv dq + gravity, w = 1 to 10 mrad/s.

One joint, or a chain of three in a plane that move in turn or at once: sines, ways from point to point, or sweeps. The
noise is white or AR(1). An effect may be hidden in the last joint; `gravity_error` is true of all.
"""

from collections.abc import Sequence

import numpy as np
from scipy.signal import butter, chirp, lfilter, sosfilt

from benchmarks.answers import ANSWER, answer_of
from benchmarks.resume import Job, Row
from friction_audit.api import diagnose_log
from friction_audit.joint_log import JointLog, Source

FIELDS = ("truth", "seed", "scenario", "joint", *ANSWER)
HIDDEN = ("stribeck", "torque_bias", "torque_ripple", "time_delay", "asymmetric_coulomb", "nonlinear_viscous")
FINE_HZ = 2000.0


def _motion(kind: str, rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    if kind == "sines":
        rates = rng.uniform(0.05, 0.6, 4)
        return np.asarray(sum(rng.uniform(0.1, 0.4) * np.sin(2 * np.pi * (f * t + rng.random())) for f in rates))
    if kind == "sweep":
        turns = chirp(t, rng.uniform(0.05, 0.1), t[-1], rng.uniform(0.5, 0.9), phi=90.0)
        return np.asarray(rng.uniform(0.4, 0.8) * turns * (1.0 - np.exp(-t)))
    goals, q, k = rng.uniform(-0.9, 0.9, 400), np.zeros_like(t), 0
    for start, goal in zip(np.append(0.0, goals), goals, strict=False):
        length = max(round(1.9 * abs(goal - start) / rng.uniform(0.2, 1.5) * FINE_HZ), 600)
        x = np.linspace(0.0, 1.0, length)
        way = np.append(start + (goal - start) * x**3 * (10 - 15 * x + 6 * x * x), np.full(rng.choice([1, 600]), goal))
        q[k : k + len(way)] = way[: len(t) - k]
        k += len(way)
        if k >= len(t):
            break
    return q


def log_of(seed: int, truth: str) -> tuple[JointLog, str]:
    """A log of one joint or three, and how it was made in words."""
    rng = np.random.default_rng([seed, 25])
    kind, way = str(rng.choice(["sines", "points", "sweep"])), str(rng.choice(["alone", "in turn", "at once"]))
    joints, rate = 1 if way == "alone" else 3, float(rng.choice([100.0, 250.0, 500.0, 1000.0]))
    t = np.arange(round(rng.uniform(60.0, 120.0) * (2 if way == "in turn" else 1) * FINE_HZ)) / FINE_HZ
    q = np.zeros((len(t), joints))
    for j, part in enumerate(np.array_split(np.arange(len(t)), joints)):
        own = part if way == "in turn" else slice(None)
        since, left = t[own] - t[own][0], t[own][-1] - t[own]
        soft = np.sin(np.pi / 2 * np.minimum(1.0, np.minimum(since, left))) ** 4  # starts and ends at rest
        q[own, j] = soft * _motion(kind, rng, since)
    dq, size = np.asarray(np.gradient(q, 1 / FINE_HZ, axis=0)), np.exp(rng.uniform(-1.5, 1.2, joints))
    width, coulomb = float(np.exp(rng.uniform(*np.log([1e-3, 1e-2])))), size * rng.uniform(0.6, 1.4, joints)
    sign, viscous = dq / np.sqrt(dq**2 + width**2), size * rng.uniform(0.2, 0.9, joints)
    strength, last, extra = rng.uniform(0.5, 2.0), q[:, -1], np.zeros_like(q)
    extra[:, -1] = strength * coulomb[-1] * {
        "stribeck": 0.3 * sign[:, -1] * np.exp(-np.abs(dq[:, -1]) / 0.08),
        "torque_bias": np.full(len(t), 0.15),
        "torque_ripple": 0.1 * np.sin(60.0 * last),
        "asymmetric_coulomb": 0.1 * np.abs(sign[:, -1]),
        "nonlinear_viscous": 0.3 * dq[:, -1] * np.abs(dq[:, -1]),
    }.get(truth, np.zeros(len(t)))  # fmt: skip
    torque = 0.4 * size * np.asarray(np.gradient(dq, 1 / FINE_HZ, axis=0)) + coulomb * sign + viscous * dq + extra
    angle, weight, phase = np.cumsum(q, axis=1), rng.uniform(2.0, 9.0, joints) * size, rng.uniform(0, 6.28, joints)
    torque += np.cumsum((weight * np.sin(angle + phase))[:, ::-1], axis=1)[:, ::-1]
    if truth == "time_delay":
        torque[:, -1] = np.interp(t - 0.008 * strength, t, torque[:, -1])
    every = round(FINE_HZ / rate)
    t, q, dq, torque = t[::every], q[::every], dq[::every], torque[::every]
    level, pole = 0.02 * coulomb * rng.uniform(0.5, 2.0), rng.choice([0.0, np.exp(-1.0 / (rate * 0.02))])
    torque = torque + level * lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.normal(size=torque.shape), axis=0)
    dq = dq + rng.normal(size=dq.shape) * 2e-3
    if rng.random() < 0.5:
        dq = sosfilt(butter(2, 0.2 * rate, fs=rate, output="sos"), dq, axis=0)
    bits = 2 * np.pi / 2.0 ** rng.integers(17, 21)
    names, source = tuple(f"joint{j + 1}" for j in range(joints)), Source(path="", sha256="", format="")
    log = JointLog(t=t, q=np.round(q / bits) * bits, dq=dq, tau_J=torque, joint_names=names, source=source)
    return log, f"{kind} {way} {1e3 * width:.1f} mrad/s {rate:.0f} Hz"


def run_one(task: Row) -> list[dict[str, object]]:
    """The rows of a log; of a hidden effect that of the last joint."""
    log, scenario = log_of(int(task["seed"]), task["truth"])
    names = "+".join(name for name in ("gravity_error", task["truth"]) if name != "none")
    found = diagnose_log(log).joints[0 if task["truth"] == "none" else -1 :]
    return [
        {"truth": names, "seed": task["seed"], "scenario": scenario, "joint": one.joint, **answer_of(one)}
        for one in found
    ]


def job(truths: Sequence[str], seeds: Sequence[int]) -> Job:
    """Diagnose joints of some seeds."""
    return Job(FIELDS, [{"truth": truth, "seed": str(seed)} for truth in truths for seed in seeds], run_one)
