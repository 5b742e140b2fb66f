"""Backlash: a gap between motor and link that opens at every reversal, and the impact that closes it."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength


@dataclass(frozen=True, kw_only=True, slots=True)
class Backlash(HiddenEffect):
    """A dead zone between motor and link with elastic contact at both flanks."""

    summary = "a gap between motor and link opens at every reversal"

    gap_rad: float = strength(0.002, "full width of the gap", "rad", upper=0.1)
    contact_compliance_rad_per_nm: float = number(
        0.0001, "twist per torque in contact", "rad/(N m)", lower=1e-05, upper=0.01
    )
    contact_damping_ratio: float = number(0.2, "damping ratio of the contact", like="flank_damping_ratio")

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        share, gap, contact_hz, damping_ratio, far_share = values.values()
        must(abs(share - 1.0) <= 2 * ALIKE, "all inertia and friction are on the link side of its backlash")
        must(far_share >= 1.0 - ALIKE, "all inertia is on the link side of its backlash")
        return {
            "gap_rad": gap,
            "contact_compliance_rad_per_nm": 1.0 / (setting.joint.inertia_kg_m2 * (2.0 * math.pi * contact_hz) ** 2),
            "contact_damping_ratio": setting.with_both_sides_free(damping_ratio),
        }


@compiled()
def engaged(group: Record, stretch: float) -> float:
    """Return what is left of the stretch (motor less link) after the dead zone; the stretch itself without a gap. [rad]

    The dead zone of Nordin and Gutman, Controlling mechanical systems with backlash (2002): 0 in the gap.
    """
    half = 0.5 * group.gap_rad
    if stretch > half:
        return float(stretch - half)
    if stretch < -half:
        return float(stretch + half)
    return 0.0


@compiled()
def contact_nm(group: Record, engaged_rad: float) -> float:
    """Return the elastic torque of the flanks, signed as the stretch that is left after the dead zone. [N m]"""
    return float(engaged_rad / group.contact_compliance_rad_per_nm)


@compiled()
def contact_damping_nms_per_rad(group: Record, inertia: float) -> float:
    """Return the damping of the flanks while they touch, which takes the energy of the impact. [N m s/rad]

    Inertia: the reduced one of both sides. [kg m^2]
    """
    return float(2.0 * group.contact_damping_ratio * math.sqrt(inertia / group.contact_compliance_rad_per_nm))
