"""Columns like those of a joint moved to and fro, and noise with a memory: no robot, no formulas of the detector."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from friction_audit.diagnosis.gram import Index
from friction_audit.diagnosis.groups import Group
from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class SyntheticColumns:
    """Base, candidates and noise of one data set; noise has a standard deviation of 1."""

    noise: Float
    base: Float
    groups: tuple[Group, ...]
    cycle: Index
    n_eff: float

    def partial(self, group: int, shape: int) -> Float:
        """Direction of one candidate free of the base, with a root mean square of 1, shape (n,)."""
        torque = self.groups[group].shapes[shape].sum(axis=1)
        free = torque - self.base @ np.linalg.lstsq(self.base, torque, rcond=None)[0]
        return np.asarray(free / np.sqrt(np.mean(free**2)))


def synthetic_columns(
    rng: np.random.Generator, *, cycles: int, memory: float, per_cycle: int = 100
) -> SyntheticColumns:
    """Draws one data set with noise e[i] = memory e[i-1] + white."""
    n = cycles * per_cycle
    cycle = np.repeat(np.arange(cycles), per_cycle)
    phase = np.tile(2 * np.pi * (np.arange(per_cycle) + 0.5) / per_cycle, cycles)
    size = np.repeat(rng.uniform(0.3, 1.2, cycles), per_cycle)
    v, a = size * np.sin(phase), size * np.cos(phase)
    q = np.repeat(rng.uniform(-1, 1, cycles), per_cycle) - a
    return SyntheticColumns(
        noise=autoregressive(rng, n, memory),
        base=np.column_stack([a, np.sign(v), v]),
        groups=_groups(v, q, np.linspace(0, 1, n)),
        cycle=cycle,
        n_eff=n * (1 - memory) / (1 + memory),
    )


def autoregressive(rng: np.random.Generator, n: int, memory: float) -> Float:
    """Stationary noise of the first order, standard deviation 1."""
    start = 600
    white = rng.standard_normal(n + start) * np.sqrt(1 - memory**2)
    return np.asarray(lfilter([1.0], [1.0, -memory], white)[start:])


def _groups(v: Float, q: Float, t: Float) -> tuple[Group, ...]:
    """Twelve candidates, twenty-five with their shapes, many of them alike."""
    s = np.sign(v)
    shapes: dict[str, tuple[Float, ...]] = {
        "constant": (np.ones((len(v), 1)),),
        "even": (np.abs(v)[:, None],),
        "square": ((v * np.abs(v))[:, None],),
        "cube": ((v**3)[:, None],),
        "peak": tuple((s * np.exp(-np.abs(v) / w))[:, None] for w in (0.03, 0.06, 0.1, 0.2)),
        "wave": tuple(np.column_stack([np.sin(k * q), np.cos(k * q)]) for k in (5, 8, 13)),
        "pendulum": (np.column_stack([np.sin(q), np.cos(q)]),),
        "spring": (q[:, None],),
        "ramp": (t[:, None] - 0.5,),
        "fading": tuple((s * np.exp(-t / w))[:, None] for w in (0.2, 0.5, 1.0)),
        "step": tuple((s * (t > at))[:, None] for at in (0.2, 0.4, 0.6, 0.8)),
        "placed": tuple((s * np.sin(k * q))[:, None] for k in (1, 2, 3, 4)),
    }
    return tuple(Group(name=name, shapes=columns) for name, columns in shapes.items())
