"""Effects that no catalogue of friction holds, added to the logged torque itself."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.hidden_effects.draw import Case, settings_of
from benchmarks.hidden_effects.strength import left_over
from friction_audit.joint_log import Float, JointLog
from friction_audit.simulation.scenarios import simulate

Torque = Callable[[Float, Float, Float, np.random.Generator], Float]


def hum(t: Float, _q: Float, _dq: Float, rng: np.random.Generator) -> Float:
    """A motor next door: a sine in time."""
    return np.asarray(np.sin(2 * np.pi * rng.uniform(1.0, 12.0) * t + rng.uniform(0, 2 * np.pi)))


def flips(t: Float, _q: Float, dq: Float, rng: np.random.Generator) -> Float:
    """A brake that rubs now and then: friction that switches at random moments."""
    every = rng.uniform(1.0, 4.0)
    state = rng.integers(0, 2, int(t[-1] / every) + 2).astype(np.float64)
    return np.asarray(np.tanh(dq / 0.01) * state[(t / every).astype(int)], np.float64)


def acceleration_friction(_t: Float, _q: Float, dq: Float, rng: np.random.Generator) -> Float:
    """Friction that grows with the size of the acceleration."""
    bend = np.gradient(np.convolve(dq, np.hanning(101) / 50.0, mode="same"), 1e-3)
    return np.tanh(dq / 0.01) * np.abs(bend) ** rng.uniform(0.8, 1.2)


def winding(_t: Float, q: Float, dq: Float, rng: np.random.Generator) -> Float:
    """A hose that twists: torque by the path travelled so far, fading as it slips."""
    path = np.cumsum(np.abs(np.gradient(q)))
    return np.sin(path / rng.uniform(0.3, 1.0)) * np.tanh(np.abs(dq) / 0.05)


OUTSIDE: tuple[tuple[str, Torque], ...] = (
    ("hum", hum),
    ("flips", flips),
    ("acceleration_friction", acceleration_friction),
    ("winding", winding),
)
"""By name."""


def log_with(case: Case, kind: str) -> JointLog:
    """The log of a case with nothing hidden, and one of these torques in it at the strength asked for."""
    plain = simulate(settings_of(case, ()), case.seed).log
    ideal = simulate(settings_of(case, (), ideal=True), case.seed).log
    make = dict(OUTSIDE)[kind]
    noise, clean = left_over(plain, 0), left_over(ideal, 0)
    size = 0.05
    for _ in range(3):
        total = left_over(_added(ideal, make, size, case.seed), 0)
        size *= noise * case.partial / float(np.sqrt(max(total**2 - clean**2, 1e-12)))
    return _added(plain, make, size, case.seed)


def _added(log: JointLog, make: Torque, size: float, seed: int) -> JointLog:
    torque = make(log.t, log.q[:, 0], log.dq[:, 0], np.random.default_rng([seed, 7]))[:, None]
    # On the sensor a torque that the joint takes reads with the other sign.
    if log.tau_interaction is not None:
        return replace(log, tau_interaction=log.tau_interaction + size * torque)
    return replace(log, tau_J=log.tau_J - size * torque)  # type: ignore[operator]
