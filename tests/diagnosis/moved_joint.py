"""A joint on the fine grid whose motion and torque are formulas: no simulator, no filter."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from friction_audit.effects.joint_data import JointData, mean_sign
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import joint_of

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
    q, dq, ddq = np.zeros((3, len(t)))
    for size, w, phase in ((0.6, 2.0, 0.3), (0.3, 3.1, 1.0), (0.2, 0.83, 2.0)):
        q += size * np.sin(w * t + phase)
        dq += size * w * np.cos(w * t + phase)
        ddq -= size * w**2 * np.sin(w * t + phase)
    ends = (t < 0.2) | (t > t[-1] - 0.2)
    torque = INERTIA_KG_M2 * ddq + COULOMB_NM * mean_sign(t, dq, ddq) + VISCOUS_NMS_PER_RAD * dq
    noise = noise_nm / NOISE_LEFT * np.random.default_rng(seed).standard_normal(len(t))
    data = joint_of(t, q, dq, ddq, torque + noise, moving=np.ones(len(t), bool), valid=~ends, dead_speed_rad_s=1e-4)
    return data if missing is None else replace(data, torque=data.torque + missing(data))
