"""Torque feedback in an elastic joint, sampled: how large its gain may be."""

from typing import NamedTuple

import numpy as np

from friction_audit.joint_log import Float

GAINS = np.geomspace(1e-3, 1e4, 701)
"""Searched for the first that is unstable; between two neighbours the limit is then halved in."""

HALVINGS = 40

ROUNDING = 1e-9
"""A joint without damping rings for ever, at an eigenvalue of 1 but for rounding."""


class ElasticJoint(NamedTuple):
    """Motor and outer inertia with a spring and a damper between them."""

    inertia_kg_m2: float
    outer_inertia_kg_m2: float
    stiffness_nm_per_rad: float
    damping_nms_per_rad: float


def largest_torque_gain(joint: ElasticJoint, share: float, period_s: float) -> float:
    """Return the largest stable G of u = G y, with y the measured torque behind a low-pass; inf if there is none.

    Args:
        joint: The joint; without friction, and nobody holds it.
        share: Share of the way to the latest torque that the low-pass goes in a tick, 1 without filter.
        period_s: Tick; u is held over it. [s]
    """
    plant = _held(joint, period_s)
    sensor = -np.array([joint.stiffness_nm_per_rad, joint.damping_nms_per_rad])

    def unstable(gain: float) -> bool:
        return bool(np.abs(np.linalg.eigvals(_closed(plant, sensor, share, gain))).max() > 1.0 + ROUNDING)

    beyond = next((i for i, gain in enumerate(GAINS) if unstable(float(gain))), None)
    if beyond is None:
        return np.inf
    low, high = (float(GAINS[beyond - 1]) if beyond > 0 else 0.0), float(GAINS[beyond])
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low


def _held(joint: ElasticJoint, period_s: float) -> Float:
    """Return transition [2, 2] and input [2, 1] of twist and its rate over a tick, side by side, shape (2, 3)."""
    from scipy.linalg import expm

    inverse = 1.0 / joint.inertia_kg_m2 + 1.0 / joint.outer_inertia_kg_m2
    spring, damper = -joint.stiffness_nm_per_rad * inverse, -joint.damping_nms_per_rad * inverse
    rates = np.array([[0.0, 1.0, 0.0], [spring, damper, 1.0 / joint.inertia_kg_m2], [0.0, 0.0, 0.0]])
    return np.asarray(expm(rates * period_s)[:2], dtype=np.float64)


def _closed(plant: Float, sensor: Float, share: float, gain: float) -> Float:
    """Return the transition of twist, its rate and the filtered torque over a tick, the loop closed."""
    filtered = np.array([*(share * sensor), 1.0 - share])
    return np.vstack([plant @ np.vstack([np.eye(2, 3), gain * filtered]), filtered])
