"""Compensators that feed back what the joint does: a friction observer, and a torque regulation that shapes inertia.

L. Le Tien, A. Albu-Schaeffer, A. De Luca, G. Hirzinger: Friction observer and compensation for control of robots with
joint torque measurement, IEEE/RSJ International Conference on Intelligent Robots and Systems, 2008.

A. Albu-Schaeffer, C. Ott, G. Hirzinger: A unified passivity-based control framework for position, torque and impedance
control of flexible joint robots, International Journal of Robotics Research 26(1), 2007.
"""

import math
from dataclasses import dataclass, replace
from typing import Self

from friction_audit.compensation.compensators.law import Law, soft_sign
from friction_audit.compiled import Record, compiled
from friction_audit.errors import UsageError


@dataclass(frozen=True, kw_only=True, slots=True)
class DisturbanceObserver(Law):
    """u = gain times the observed friction, whose rate is L (F_m + u - B ddq - observed friction).

    Without a dead-band a joint that sticks is pushed free by nothing but noise and bias, which the observer adds up;
    it then hunts. In the dead-band it is therefore silent, and observes on.
    """

    where, gains = "disturbance observer", ("observer_gain_per_s",)
    positive = ("observer_gain_per_s",)
    not_negative = ("inertia_kg_m2", "dead_band_rad_s", "ramp_rad_s")

    inertia_kg_m2: float  # motor inertia B as assumed [kg m^2]
    observer_gain_per_s: float  # L, bandwidth of the observer [1/s]
    compensation_gain: float = 1.0  # share of the observed friction that is compensated
    dead_band_rad_s: float = 0.01  # speed up to which it is silent [rad/s]
    # range of speed over which it then rises to all of it; dead-band and ramp 0: always all of it, as published [rad/s]
    ramp_rad_s: float = 0.03

    def __post_init__(self) -> None:
        Law.__post_init__(self)
        if not 0 < self.compensation_gain <= 1:
            raise UsageError(
                f"disturbance observer: compensation_gain {self.compensation_gain:g}: expected a share above 0, up to 1"
            )


@compiled(inline=True)
def observe(group: Record, memory: Record, dq: float, interaction_nm: float, dt: float) -> None:
    """Observe the past interval, exactly for friction that is steady over it.

    F_m is taken as read at the end of the interval, while the u of the interval acted. Its value at the start was read
    under the u before, and the jump between them is no friction.
    """
    if dt <= 0.0:
        return
    unexplained = interaction_nm + memory.u_nm - group.inertia_kg_m2 * (dq - memory.dq) / dt
    memory.observed_friction_nm -= math.expm1(-group.observer_gain_per_s * dt) * (
        unexplained - memory.observed_friction_nm
    )


@compiled(inline=True)
def observed_nm(group: Record, memory: Record, dq: float) -> float:
    """Return the torque that cancels the observed friction. [N m]"""
    share = 1.0
    if group.dead_band_rad_s + group.ramp_rad_s > 0.0:
        share = abs(soft_sign(dq, group.dead_band_rad_s, group.ramp_rad_s))
    return float(share * group.compensation_gain * memory.observed_friction_nm)


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueRegulation(Law):
    """u = (B / B_theta - 1) F_m, so that B_theta ddq = F_m - (B_theta / B) tau_f.

    The torque does not depend on the velocity: nothing chatters at standstill, and a joint breaks away at B_theta / B
    of its friction.
    """

    where = "torque regulation"
    positive = ("inertia_kg_m2", "desired_inertia_kg_m2", "cutoff_hz")

    inertia_kg_m2: float  # motor inertia B as assumed [kg m^2]
    desired_inertia_kg_m2: float  # B_theta; above B the joint gets heavier [kg m^2]
    cutoff_hz: float = math.inf  # corner of the first-order low-pass on F_m; infinite for none [Hz]

    def scaled(self, factor: float) -> Self:
        """Return it with its torque gain B / B_theta - 1 times a factor."""
        gain = factor * (self.inertia_kg_m2 / self.desired_inertia_kg_m2 - 1.0)
        return replace(self, desired_inertia_kg_m2=self.inertia_kg_m2 / (1.0 + gain))


@compiled(inline=True)
def filter_torque(group: Record, memory: Record, interaction_nm: float, dt: float) -> None:
    """Filter the torque just read; the first one is taken as it is."""
    share = 1.0 if memory.ticks == 0 else -math.expm1(-2.0 * math.pi * group.cutoff_hz * dt)
    memory.filtered_interaction_nm += share * (interaction_nm - memory.filtered_interaction_nm)


@compiled(inline=True)
def regulated_nm(group: Record, memory: Record) -> float:
    """Return the torque that shapes the inertia. [N m]"""
    return float((group.inertia_kg_m2 / group.desired_inertia_kg_m2 - 1.0) * memory.filtered_interaction_nm)
