"""Clean joints of a third generator: friction whose sign is smoothed, B dw = u - Fc tanh(w / w0) - Fv w.

A motor follows reaches or sums of sines; nothing is hidden but the smoothing width, 1 to 10 mrad/s. The loop is written
with `math` and the noise is an AR(1) process: nothing here is shared with the two other generators.
"""

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numba import njit
from scipy.signal import lfilter

from benchmarks.answers import ANSWER, answer_of
from benchmarks.resume import Job, Row
from friction_audit.api import diagnose_log, read_log
from friction_audit.joint_log import JointLog

STEP_S, RATE_HZ = 1e-4, 1000.0
FIELDS = ("truth", "seed", "scenario", "joint", *ANSWER)


@njit(cache=True)
def _integrate(
    wanted: np.ndarray,
    inertia: float,
    coulomb: float,
    viscous: float,
    width: float,
    stiffness: float,
    damping: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n = len(wanted)
    q, w, u = np.empty(n), np.empty(n), np.empty(n)
    position, speed = wanted[0], 0.0
    for k in range(n):
        ahead = (wanted[min(k + 1, n - 1)] - wanted[k]) / STEP_S
        drive = stiffness * (wanted[k] - position) + damping * (ahead - speed)
        q[k], w[k], u[k] = position, speed, drive
        # Semi-implicit in the friction: its slope at rest, coulomb / width, is stiff.
        slope = (coulomb / width) * (1.0 - math.tanh(speed / width) ** 2) + viscous
        force = drive - coulomb * math.tanh(speed / width) - viscous * speed
        speed += STEP_S * force / (inertia + STEP_S * slope)
        position += STEP_S * speed
    return q, w, u


def _motion(rng: np.random.Generator, duration_s: float) -> np.ndarray:
    """Reaches of minimal jerk with rests between some of them, or a sum of sines."""
    t = np.arange(round(duration_s / STEP_S)) * STEP_S
    if rng.random() < 0.4:
        rates = rng.uniform(0.1, 0.9, 5)
        return np.asarray(sum(rng.uniform(0.1, 0.5) * np.sin(2 * np.pi * (f * t + rng.random())) for f in rates))
    out, at, k = np.empty_like(t), 0.0, 0
    while k < len(t):
        length = round(rng.uniform(0.8, 3.0) / STEP_S)
        goal = rng.uniform(-0.9, 0.9)
        x = np.linspace(0.0, 1.0, length)
        piece = at + (goal - at) * (10 * x**3 - 15 * x**4 + 6 * x**5)
        rest = np.full(round(rng.choice([0.0, 0.0, 0.4]) / STEP_S), goal)
        both = np.concatenate([piece, rest])[: len(t) - k]
        out[k : k + len(both)], k, at = both, k + len(both), goal
    return out


def log_of(seed: int) -> tuple[JointLog, str]:
    """A log of one joint, and its smoothing width in words."""
    rng = np.random.default_rng([seed, 77])
    inertia, coulomb, viscous = rng.uniform(0.1, 0.6), rng.uniform(0.2, 1.1), rng.uniform(0.03, 0.1)
    width = float(np.exp(rng.uniform(np.log(1e-3), np.log(1e-2))))
    rate = 2 * np.pi * rng.uniform(4.0, 7.0)
    wanted = _motion(rng, float(rng.uniform(60.0, 120.0)))
    q, w, u = _integrate(wanted, inertia, coulomb, viscous, width, inertia * rate**2, 1.4 * inertia * rate)
    every = round(1.0 / (STEP_S * RATE_HZ))
    q, w, u = q[::every], w[::every], u[::every]
    level, memory = rng.uniform(0.01, 0.05), rng.uniform(0.002, 0.08)
    pole = math.exp(-1.0 / (RATE_HZ * memory))
    noise = lfilter([math.sqrt(1 - pole**2)], [1.0, -pole], rng.normal(size=len(u))) * level
    torque = np.round((u + noise) / 0.006) * 0.006
    bits = 2 * np.pi / 2.0 ** rng.integers(17, 21)
    columns = [np.arange(len(q)) / RATE_HZ, np.round(q / bits) * bits, w + rng.normal(size=len(w)) * 0.002, torque]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        np.savetxt(path, np.column_stack(columns), fmt="%.8g", delimiter=",", header="time,q_1,dq_1,tau_interaction_1",
                   comments="")  # fmt: skip
        return read_log(path), f"width {1e3 * width:.1f} mrad/s"


def run_one(task: Row) -> list[dict[str, object]]:
    """The row of one joint."""
    log, scenario = log_of(int(task["seed"]))
    (joint,) = diagnose_log(log).joints
    return [{"truth": "none", "seed": task["seed"], "scenario": scenario, "joint": 1, **answer_of(joint)}]


def job(seeds: Sequence[int]) -> Job:
    """Diagnose joints of some seeds."""
    return Job(FIELDS, [{"truth": "none", "seed": str(seed)} for seed in seeds], run_one)
