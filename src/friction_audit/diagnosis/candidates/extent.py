"""How fast, how far and how long the joint of a log moves: what grids of shapes are measured in."""

import numpy as np

from friction_audit.diagnosis.joint_data import JointData
from friction_audit.joint_log import Float


def speeds(data: JointData, *percent: float) -> Float:
    """Percentiles of the speed while the joint moves, never 0, shape (k,). [rad/s]"""
    speed = np.abs(data.dq[data.used]) if data.used.any() else np.abs(data.dq)
    return np.asarray(np.maximum(np.percentile(speed, percent), data.dead_speed_rad_s))


def reach(data: JointData) -> tuple[float, float]:
    """Lowest and highest position while the joint moves. [rad]"""
    q = data.q[data.used] if data.used.any() else data.q
    return float(q.min()), float(q.max())


def duration(data: JointData) -> float:
    """Length of the log. [s]"""
    return float(data.t[-1] - data.t[0])
