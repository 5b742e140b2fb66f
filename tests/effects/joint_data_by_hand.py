"""Joints by hand: a motion, no simulator; and how much of a torque an effect explains."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import lstsq

from friction_audit.dynamics.motion import Others
from friction_audit.effects.breakaway import find_breakaways, signed_rest
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, Nominal, mean_sign
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.joint_log import Float

STEP_S = 0.005


def joint_of(t: Float, q: Float, dq: Float, ddq: Float, torque: Float, **given: Any) -> JointData:
    """A joint alone, valid throughout; every stroke is a cycle."""
    alone = Others(joint=0, q=q[:, None], dq=dq[:, None], ddq=ddq[:, None], sensed=torque[:, None])
    known: dict[str, Any] = {"joint": 0, "others": alone, "dead_speed_rad_s": 0.01} | given
    strokes = np.concatenate([[0], np.cumsum(np.diff(np.sign(dq)) != 0)]).astype(np.int64)
    marks = {"cycle": strokes, "moving": np.abs(dq) > known["dead_speed_rad_s"], "valid": np.ones(len(t), bool)}
    return JointData(t=t, q=q, dq=dq, ddq=ddq, torque=torque, **(marks | known))


STROKES = ((0.6, 2.0, 0.3), (0.3, 3.1, 1.0), (0.2, 0.83, 2.0))  # to and fro, at speeds that change


def sines(t: Float, *parts: tuple[float, float, float]) -> tuple[Float, Float, Float]:
    """Position, velocity and acceleration of sines of amplitude, angular frequency and phase."""
    angles = [(size, w, w * t + phase) for size, w, phase in parts]
    q = sum(size * np.sin(angle) for size, _, angle in angles)
    dq = sum(size * w * np.cos(angle) for size, w, angle in angles)
    ddq = sum(-size * w**2 * np.sin(angle) for size, w, angle in angles)
    return np.asarray(q), np.asarray(dq), np.asarray(ddq)


def joint_data(q: Float, dq: Float, ddq: Float) -> JointData:
    """A joint with noise for a torque, between two that move in their own way."""
    rng, n = np.random.default_rng(0), len(q)
    t: Float = np.arange(n, dtype=np.float64) * STEP_S
    torque = rng.normal(size=n)
    moved = {name: rng.normal(size=(n, 3)) for name in ("dq", "ddq", "sensed")}
    others = Others(joint=1, q=np.zeros((n, 3)), **moved)
    return joint_of(t, q, dq, ddq, torque, joint=1, others=others, temperature=25.0 + t / 60.0)


def two_sines(duration_s: float = 60.0) -> JointData:
    return joint_data(*sines(np.arange(0.0, duration_s, STEP_S), (0.7, 2.0, 0.0), (0.4, 3.3, 0.0)))


def typical_term(term: Effect) -> FittedTerm:
    """A term with numbers well within the bounds: geometric middles, else a little above the lowest."""
    values = []
    for low, high in ((one.lower, one.upper) for one in term.parameters):
        middle = np.sqrt(low * high) if low > 0.0 else low + 0.6 * (high - low)
        values.append(float(middle) if np.isfinite(high) else (low if np.isfinite(low) else 0.0) + 0.3)
    if term.name == "presliding":  # with the damping of the middle bristles would be a damper
        values = [0.3, 0.005, 1.0, 0.005]
    return FittedTerm(term.name, tuple(values))


def at_rest(n: int = 2000) -> JointData:
    return joint_data(np.full(n, 0.3), np.zeros(n), np.zeros(n))


def baseline(data: JointData) -> Nominal:
    torque = 0.3 * data.ddq + 0.3 * np.clip(data.dq / 0.01, -1, 1) + 0.07 * data.dq
    return Nominal(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07, torque=torque)


def share_explained(effect: Effect, data: JointData, torque: Float) -> float:
    """Share of what the nominal model leaves of a torque, shape (n,), by the best point with possible coefficients."""
    used = np.flatnonzero(data.used)[::2]
    nominal, y = np.column_stack([data.ddq, np.sign(data.dq), data.dq])[used], torque[used]

    # An orthogonal factorisation with pivots takes half the time of singular values.
    solve = partial(lstsq, cond=1e-10, lapack_driver="gelsy", check_finite=False)

    def fit(own: Float) -> tuple[Float, float]:
        columns = np.column_stack([nominal, own])
        size = np.sqrt(np.mean(columns**2, axis=0))
        there = size > 0.0  # rounding of a zero coefficient may have an impossible sign
        size[~there] = 1.0
        coefficients = np.where(there, solve(columns / size, y)[0] / size, 0.0)
        return coefficients[3:], float(np.sum((y - columns @ coefficients) ** 2))

    nothing, best = fit(np.zeros((len(y), 0)))[1], 0.0
    for shape in effect.grid(data):
        coefficients, left = fit(effect.regressor(data, baseline(data), shape)[used])
        if effect.possible(coefficients, shape):
            best = max(best, 1.0 - left / nothing)
    return best


# A joint on the fine grid whose motion and torque are formulas: no simulator, no filter.

GRID_HZ = 400.0
COULOMB_NM, VISCOUS_NMS_PER_RAD, INERTIA_KG_M2 = 0.3, 0.07, 0.2
NOISE_LEFT = 0.327
"""Of noise that is white up to 200 Hz, after a low-pass at 25 Hz: root of the sum of the squares of its weights."""
TRUTH = {"coulomb_nm": COULOMB_NM, "viscous_nms_per_rad": VISCOUS_NMS_PER_RAD, "inertia_kg_m2": INERTIA_KG_M2}


def moved_joint(
    missing: Callable[[JointData], Float] | None = None,
    *,
    noise_nm: float = 0.0,
    duration_s: float = 60.0,
    seed: int = 0,
) -> JointData:
    """A joint moved to and fro, every stroke a cycle, at speeds that change; white noise up to the grid's Nyquist.

    ``missing`` is torque that the declared model does not hold, ``noise_nm`` about what is left of noise at the rows.
    """
    t: Float = np.arange(0.0, duration_s, 1.0 / GRID_HZ)
    q, dq, ddq = sines(t, *STROKES)
    ends = (t < 0.2) | (t > t[-1] - 0.2)
    torque = INERTIA_KG_M2 * ddq + COULOMB_NM * mean_sign(t, dq, ddq) + VISCOUS_NMS_PER_RAD * dq
    noise = noise_nm / NOISE_LEFT * np.random.default_rng(seed).standard_normal(len(t))
    data = joint_of(t, q, dq, ddq, torque + noise, moving=np.ones(len(t), bool), valid=~ends, dead_speed_rad_s=1e-4)
    return data if missing is None else replace(data, torque=data.torque + missing(data))


# A joint on the fine grid that breaks away from a standstill again and again: no simulator, no filter.

EXCESS_NM, RISE_NM_PER_S = 0.2, 1.5


def started_and_stopped(noise_nm: float = 0.0, starts: int = 20) -> JointData:
    """A joint that stands still for half of every second, its torque rising, then slides, the excess lost at once."""
    t = np.arange(0.0, starts, 1.0 / 400.0)
    since, direction = t % 1.0 - 0.5, np.where(t % 2.0 < 1.0, 1.0, -1.0)
    slides = since >= 0.0
    dq = np.where(slides, direction * (1.0 - np.cos(4 * np.pi * since)), 0.0)
    held = COULOMB_NM + EXCESS_NM + RISE_NM_PER_S * since
    torque = direction * np.where(slides, COULOMB_NM, held)
    q = np.cumsum(dq) / 400.0
    signed, ddq = signed_rest(dq, np.gradient(dq, t), find_breakaways(q, dq, 3e-3, 1 / 400), 3e-3)
    noise = noise_nm * np.random.default_rng(0).standard_normal(len(t))
    cycle, moving = (t // 1.0).astype(np.int64), np.abs(dq) > 3e-3
    return joint_of(t, q, signed, ddq, torque + noise, cycle=cycle, moving=moving, dead_speed_rad_s=3e-3)
