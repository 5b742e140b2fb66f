"""A joint on the fine grid that breaks away from a standstill again and again: no simulator, no filter."""

import numpy as np

from friction_audit.effects.breakaway import find_breakaways, signed_rest
from friction_audit.effects.joint_data import JointData
from tests.effects.joint_data_by_hand import joint_of

COULOMB_NM, EXCESS_NM, RISE_NM_PER_S = 0.3, 0.2, 1.5


def started_and_stopped(noise_nm: float = 0.0, starts: int = 20) -> JointData:
    """A joint that stands still for half of every second, its torque rising, then slides, the excess lost at once."""
    t = np.arange(0.0, starts, 1.0 / 400.0)
    since, way = t % 1.0 - 0.5, np.where(t % 2.0 < 1.0, 1.0, -1.0)
    slides = since >= 0.0
    dq = np.where(slides, way * (1.0 - np.cos(4 * np.pi * since)), 0.0)
    held = COULOMB_NM + EXCESS_NM + RISE_NM_PER_S * since
    torque = way * np.where(slides, COULOMB_NM, held)
    q = np.cumsum(dq) / 400.0
    signed, ddq = signed_rest(dq, np.gradient(dq, t), find_breakaways(q, dq, 3e-3, 1 / 400), 3e-3)
    noise = noise_nm * np.random.default_rng(0).standard_normal(len(t))
    cycle, moving = (t // 1.0).astype(np.int64), np.abs(dq) > 3e-3
    return joint_of(t, q, signed, ddq, torque + noise, cycle=cycle, moving=moving, dead_speed_rad_s=3e-3)
