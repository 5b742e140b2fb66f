"""Effects added to a measured torque, by formulas that neither the simulator nor the detector knows."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.signal import savgol_filter

from friction_audit.joint_log import Float, JointLog

SIZES = (0.5, 1.0, 2.0)
"""Rms of what is added, over the robust rms that a plain regression of the measured torque leaves."""
DELAY = "time_delay"  # as large as its time makes it
Draw = Callable[[float, float], float]


def residual_rms(q: Float, v: Float, a: Float, torque: Float) -> float:
    """Robust rms that a regression on tanh(v / vs), v, a, sin q, cos q and 1 leaves. [N m]"""
    columns = np.column_stack([np.tanh(v / 0.02), v, a, np.sin(q), np.cos(q), np.ones_like(q)])
    weight, scale = np.ones_like(q), 0.0
    for _ in range(5):
        left = torque - columns @ np.linalg.lstsq(columns * weight[:, None], torque * weight, rcond=None)[0]
        scale = 1.4826 * float(np.median(np.abs(left)))
        weight = np.sqrt(1.0 / np.maximum(1.0, np.abs(left) / (2.0 * scale)))
    return scale


def torques(t: Float, q: Float, v: Float, torque: Float, rms: float, rng: np.random.Generator) -> dict[str, Float]:
    """Torque of each effect at the size of ``rms`` while the joint moves, its numbers drawn, shape (n,) each. [N m]"""
    fast, span = float(np.quantile(np.abs(v), 0.95)), float(np.ptp(q))
    moving, draw = np.abs(v) > 0.05 * fast, rng.uniform
    centre = float(np.quantile(q, draw(0.3, 0.7)))
    late = draw(0.008, 0.02)
    made = {
        "stribeck": np.exp(-(np.abs(v / (draw(0.1, 0.2) * fast)) ** draw(1.0, 2.0))) * np.sign(v),
        "torque_bias": np.ones_like(q),
        "torque_ripple": np.sin(2 * np.pi * (draw(4.0, 10.0) * (q - q.min()) / span + draw(0.0, 1.0))),
        "position_dependent_friction": np.sign(v) * np.exp(-(((q - centre) / (draw(0.08, 0.16) * span)) ** 2)),
        "torque_drift": (t - t.mean()) / np.ptp(t),
        "asymmetric_viscous": np.abs(v),
    }
    sign = float(rng.choice([-1.0, 1.0]))  # of those that may be either
    for name, one in made.items():
        size = float(np.sqrt(np.mean(one[moving] ** 2)))
        either = name in {"torque_bias", "torque_drift", "asymmetric_viscous"}
        made[name] = one * (sign if either else 1.0) * rms / max(size, 1e-12)
    made[DELAY] = np.interp(t - late, t, torque) - torque
    return made


def injected(log: JointLog, joint: int, effect: str, size: float, seed: int) -> JointLog:
    """The log with an effect added to what the sensor of one joint (1..n) reads."""
    channel = "tau_interaction" if log.tau_interaction is not None else "tau_J"
    whole = np.array(getattr(log, channel))
    torque, q, v = whole[:, joint - 1].copy(), log.q[:, joint - 1], log.dq[:, joint - 1]
    step = float(np.median(np.diff(log.t)))
    a = savgol_filter(v, 2 * max(round(0.03 / step), 2) + 1, 2, deriv=1, delta=step)
    rng = np.random.default_rng([seed, joint, len(q)])
    whole[:, joint - 1] += size * torques(log.t, q, v, torque, residual_rms(q, v, a, torque), rng)[effect]
    changed: dict[str, Any] = {channel: whole}
    return replace(log, **changed)
