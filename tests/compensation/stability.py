"""Stability limits of the feed-back compensators in a rigid or an elastic joint, from the theory of sampled loops."""

import math
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from friction_audit.compensation.compensators import DisturbanceObserver, TorqueRegulation
from friction_audit.joint_log import Float

GAINS = np.geomspace(1e-3, 1e4, 701)  # the first that is unstable is found, and the limit then by bisection
HALVINGS = 40
ROUNDING = 1e-9  # a joint without damping rings for ever, at an eigenvalue of 1 but for rounding


class ElasticJoint(NamedTuple):
    """Motor and outer inertia with a spring and a damper between them."""

    inertia_kg_m2: float
    outer_inertia_kg_m2: float
    stiffness_nm_per_rad: float
    damping_nms_per_rad: float


def largest_torque_gain(joint: ElasticJoint, share: float, period_s: float) -> float:
    """Return the largest stable G of u = G y, with y the measured torque after a low-pass; inf if there is none.

    Args:
        joint: The joint, free and without friction.
        share: Share of the way to the latest torque that the low-pass goes in a tick, 1 without filter.
        period_s: Tick; u is held over it. [s]
    """
    inverse = 1.0 / joint.inertia_kg_m2 + 1.0 / joint.outer_inertia_kg_m2
    spring, damper = -joint.stiffness_nm_per_rad * inverse, -joint.damping_nms_per_rad * inverse
    rates = np.array([[0.0, 1.0, 0.0], [spring, damper, 1.0 / joint.inertia_kg_m2], [0.0, 0.0, 0.0]])
    plant: Float = expm(rates * period_s)[:2]  # transition [2, 2] and input [2, 1] of twist and its rate over a tick
    filtered = np.array([-share * joint.stiffness_nm_per_rad, -share * joint.damping_nms_per_rad, 1.0 - share])

    def unstable(gain: float) -> bool:
        loop = np.vstack([plant @ np.vstack([np.eye(2, 3), gain * filtered]), filtered])
        return bool(np.abs(np.linalg.eigvals(loop)).max() > 1.0 + ROUNDING)

    beyond = next((i for i, gain in enumerate(GAINS) if unstable(float(gain))), None)
    if beyond is None:
        return np.inf
    low, high = (float(GAINS[beyond - 1]) if beyond > 0 else 0.0), float(GAINS[beyond])
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low


def regulation_limit(
    settings: TorqueRegulation,
    *,
    inertia_kg_m2: float,
    outer_inertia_kg_m2: float,
    period_s: float,
    stiffness_nm_per_rad: float = math.inf,
    damping_nms_per_rad: float = 0.0,
) -> float:
    """Return the smallest stable desired inertia B_theta; above it the loop is stable. [kg m^2]

    In a rigid joint, with a = 1 - exp(-2 pi f dt), 1 without filter, the filtered torque follows
    y[k+1] = (1 - a - a gain) y[k] + ...: stable while the gain of the loop stays below 2 / a - 1. In an elastic joint
    the phase that tick and filter lose at the ringing counts, and a filter may do harm.

    Args:
        settings: Assumed inertia and filter; the desired inertia does not matter.
        inertia_kg_m2: True motor inertia B. [kg m^2]
        outer_inertia_kg_m2: Inertia m on the other side of the sensor: link and hand. [kg m^2]
        period_s: Tick of the controller. [s]
        stiffness_nm_per_rad: Between motor and outer inertia, the sensor in series; infinite if rigid. [N m/rad]
        damping_nms_per_rad: Parallel to it. [N m s/rad]
    """
    share = -math.expm1(-2.0 * math.pi * settings.cutoff_hz * period_s)
    if math.isinf(stiffness_nm_per_rad):
        largest = (2.0 / share - 1.0) * (outer_inertia_kg_m2 + inertia_kg_m2) / outer_inertia_kg_m2
    else:
        joint = ElasticJoint(inertia_kg_m2, outer_inertia_kg_m2, stiffness_nm_per_rad, damping_nms_per_rad)
        largest = largest_torque_gain(joint, share, period_s)
    return settings.inertia_kg_m2 / (1.0 + largest)


def observer_limit(
    settings: DisturbanceObserver, *, inertia_kg_m2: float, outer_inertia_kg_m2: float, period_s: float
) -> float:
    """Return the largest observer gain L in a rigid joint, inf if there is none. [1/s]

    Motor B and outer inertia m turn as one; u acts a tick after the sensors were read. The observed friction then
    follows r[k+1] = (1 - a (1 - g e)) r[k] + ..., with a = 1 - exp(-L dt), compensation gain g and
    e = (B - B_assumed) / (m + B). With the right inertia or too small a one any L is stable; with one too large it
    takes a (1 - g e) < 2.

    Args:
        settings: The observer; its own L does not matter.
        inertia_kg_m2: True motor inertia B. [kg m^2]
        outer_inertia_kg_m2: Inertia m on the other side of the sensor: link and hand. [kg m^2]
        period_s: Tick of the controller. [s]
    """
    error = (inertia_kg_m2 - settings.inertia_kg_m2) / (outer_inertia_kg_m2 + inertia_kg_m2)
    largest = 2.0 / (1.0 - settings.compensation_gain * error)
    return inf if largest >= 1.0 else -math.log1p(-largest) / period_s
