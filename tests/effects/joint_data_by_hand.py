"""Joints by hand: a motion, no simulator; and how much of a torque an effect explains."""

from typing import Any

import numpy as np

from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.joint_log import Float

STEP_S = 0.005


def joint_of(t: Float, q: Float, dq: Float, ddq: Float, torque: Float, **given: Any) -> JointData:
    """A joint alone, valid throughout; every stroke is a cycle."""
    alone = {"others_dq": dq[:, None], "others_ddq": ddq[:, None], "others_torque": torque[:, None]}
    known: dict[str, Any] = {"joint": 0, "temperature": None, "dead_speed_rad_s": 0.01, **alone} | given
    strokes = np.concatenate([[0], np.cumsum(np.diff(np.sign(dq)) != 0)]).astype(np.int64)
    marks = {"cycle": strokes, "moving": np.abs(dq) > known["dead_speed_rad_s"], "valid": np.ones(len(t), bool)}
    return JointData(t=t, q=q, dq=dq, ddq=ddq, torque=torque, **(marks | known))


def joint_data(q: Float, dq: Float, ddq: Float) -> JointData:
    """A joint with noise for a torque, between two that move in their own way."""
    rng, n = np.random.default_rng(0), len(q)
    t: Float = np.arange(n, dtype=np.float64) * STEP_S
    torque, *others = rng.normal(size=n), *(rng.normal(size=(n, 3)) for _ in range(3))
    names = ("others_dq", "others_ddq", "others_torque")
    about = dict(zip(names, others, strict=True))
    return joint_of(t, q, dq, ddq, torque, joint=1, temperature=25.0 + t / 60.0, **about)


def two_sines(duration_s: float = 60.0) -> JointData:
    """Strokes of different length and speed."""
    t = np.arange(0.0, duration_s, STEP_S)
    q, dq, ddq = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    for size, w in ((0.7, 2.0), (0.4, 3.3)):
        q += size * np.sin(w * t)
        dq += size * w * np.cos(w * t)
        ddq -= size * w**2 * np.sin(w * t)
    return joint_data(q, dq, ddq)


def at_rest(n: int = 2000) -> JointData:
    return joint_data(np.full(n, 0.3), np.zeros(n), np.zeros(n))


def baseline(data: JointData) -> Nominal:
    torque = 0.3 * data.ddq + 0.3 * np.clip(data.dq / 0.01, -1, 1) + 0.07 * data.dq
    return Nominal(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07, torque=torque)


def share_explained(effect: Effect, data: JointData, torque: Float) -> float:
    """Share of what the nominal model leaves of a torque, shape (n,), by the best point with possible coefficients."""
    used = data.used
    nominal, y = np.column_stack([data.ddq, np.sign(data.dq), data.dq])[used], torque[used]

    def fit(own: Float) -> tuple[Float, float]:
        columns = np.column_stack([nominal, own])
        size = np.sqrt(np.mean(columns**2, axis=0))
        there = size > 0.0  # rounding of a zero coefficient may have an impossible sign
        size[~there] = 1.0
        coefficients = np.where(there, np.linalg.lstsq(columns / size, y, rcond=1e-10)[0] / size, 0.0)
        return coefficients[3:], float(np.sum((y - columns @ coefficients) ** 2))

    nothing, best = fit(np.zeros((len(y), 0)))[1], 0.0
    for shape in effect.grid(data):
        coefficients, left = fit(effect.regressor(data, baseline(data), shape)[used])
        if effect.admissible(coefficients, shape):
            best = max(best, 1.0 - left / nothing)
    return best
