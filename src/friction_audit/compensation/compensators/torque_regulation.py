"""Output torque regulation with inertia shaping: the measured torque fed back makes motor and friction smaller.

A. Albu-Schaeffer, C. Ott, G. Hirzinger: A unified passivity-based control framework for position, torque and impedance
control of flexible joint robots, International Journal of Robotics Research 26(1), 2007.
"""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from friction_audit.compensation.compensators.law import Guard, numbers_of, require_finite, require_positive
from friction_audit.compiled import compiled
from friction_audit.joint_log import Float


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueRegulation:
    """u = (B / B_theta - 1) F_m, so that B_theta ddq = F_m - (B_theta / B) tau_f.

    The torque does not depend on the velocity: nothing chatters at standstill, and a joint breaks away at B_theta / B
    of its friction.

    Attributes:
        inertia_kg_m2: Motor inertia B as assumed. [kg m^2]
        desired_inertia_kg_m2: B_theta; above B the joint gets heavier. [kg m^2]
        cutoff_hz: Corner of the first-order low-pass on F_m; infinite for none. [Hz]
        guard: Passivity controller and limits.

    Raises:
        UsageError: If a number is not above zero.
    """

    inertia_kg_m2: float
    desired_inertia_kg_m2: float
    cutoff_hz: float = math.inf
    guard: Guard = field(default_factory=Guard)

    def __post_init__(self) -> None:
        require_positive("torque regulation", self, *(GROUP.names or ()))
        require_finite("torque regulation", self, "inertia_kg_m2", "desired_inertia_kg_m2")

    @property
    def torque_gain(self) -> float:
        """B / B_theta - 1."""
        return self.inertia_kg_m2 / self.desired_inertia_kg_m2 - 1.0


GROUP = numbers_of(TorqueRegulation)

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
    from scipy.linalg import expm

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


def loop_gain(settings: TorqueRegulation, *, inertia_kg_m2: float, outer_inertia_kg_m2: float) -> float:
    """Return the gain of the loop from u over the sensor back to u in a rigid joint; 1 is its limit without filter.

    Motor B and outer inertia m turn as one: of a torque u on the motor, -m / (m + B) appears at the sensor, at once,
    and one tick later in u.

    Args:
        settings: Settings.
        inertia_kg_m2: True motor inertia B. [kg m^2]
        outer_inertia_kg_m2: Inertia m on the other side of the sensor: link and hand. [kg m^2]
    """
    return settings.torque_gain * outer_inertia_kg_m2 / (outer_inertia_kg_m2 + inertia_kg_m2)


def stability_limit(
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


@compiled()
def advance(group: Any, memory: Any, interaction_nm: float, dt: float) -> None:  # noqa: ANN401 - records
    """Filter the torque just read; the first one is taken as it is."""
    share = 1.0 if memory.ticks == 0 else -math.expm1(-2.0 * math.pi * group.cutoff_hz * dt)
    memory.filtered_interaction_nm += share * (interaction_nm - memory.filtered_interaction_nm)


@compiled()
def torque_nm(group: Any, memory: Any) -> float:  # noqa: ANN401 - records
    """Return the torque that shapes the inertia. [N m]"""
    return float((group.inertia_kg_m2 / group.desired_inertia_kg_m2 - 1.0) * memory.filtered_interaction_nm)
