"""Effects of the structure: elasticity and backlash between motor and link, and unmodelled inertia."""

import math
from math import inf

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength

LINEAR, HARDENING = range(2)
# A stiffer gear resonates too fast for the integration step, and no log distinguishes it from a rigid one. [rad/(N m)]
LEAST_COMPLIANCE = 1e-5
KNEE_NM = 1.0  # torque at which the stiffness of a strain-wave gear rises. [N m]
SMALL_NM = 0.02  # a spring that stiffens at a smaller torque is a linear one


class JointElasticity(HiddenEffect):
    """A spring and a damper between motor and link; 1e-3 rad/(N m) and 0.3 kg m^2 resonate at 9.2 Hz, link fixed."""

    summary = "the gear twists between motor and link"
    forms = ("linear", "hardening")

    compliance_rad_per_nm: float = strength(0.001, "twist per torque", "rad/(N m)", upper=0.1)
    damping_ratio: float = number(0.03, "damping ratio of the ringing", like="damping_ratio")

    def __post_init__(self) -> None:
        if 0.0 < self.compliance_rad_per_nm < LEAST_COMPLIANCE:
            found, least = f"compliance_rad_per_nm {self.compliance_rad_per_nm:g}", f"{LEAST_COMPLIANCE:g}"
            raise UsageError(f"joint_elasticity: {found}: expected 0, a rigid joint, or at least {least}")

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        must(values["soft_nm"] <= SMALL_NM, "its spring stiffens as a hyperbolic tangent, not evenly up to a torque")
        must(values["far_share"] >= 1.0 - ALIKE, "all inertia is on the link side of its spring")
        damping_ratio = setting.with_both_sides_free(values["damping_ratio"])
        compliance = values["compliance_rad_per_nm"]
        return {"compliance_rad_per_nm": compliance, "damping_ratio": damping_ratio, "form": "linear"}


@compiled()
def elastic_torque_nm(group: Record, stretch: float) -> float:
    """Return the torque of the spring, signed as the stretch; 0 for a rigid joint, which does not twist. [N m]

    Linear after Spong (1987); hardening as a strain-wave gear, half as stiff near zero torque (Tuttle and Seering 1996;
    the smooth transition after Ruderman 2012). Conservative in both forms.
    """
    compliance = group.compliance_rad_per_nm
    if compliance == 0.0:
        return 0.0
    if group.form == HARDENING:
        knee = KNEE_NM * compliance
        stretch -= knee * math.tanh(0.5 * stretch / knee)
    return float(stretch / compliance)


class Backlash(HiddenEffect):
    summary = "a gap between motor and link opens at every reversal"

    gap_rad: float = strength(0.002, "full width of the gap", "rad", upper=0.1)
    contact_compliance_rad_per_nm: float = number(
        1e-4, "twist per torque in contact", "rad/(N m)", lower=1e-5, upper=0.01
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
    """Return the twist beyond the gap: the dead zone of Nordin and Gutman (Automatica 38, 2002). [rad]"""
    beyond = abs(stretch) - 0.5 * group.gap_rad
    return math.copysign(beyond, stretch) if beyond > 0.0 else 0.0


class InertiaError(HiddenEffect):
    summary = "the reflected inertia is not that of the model"
    same_law = ""

    extra_kg_m2: float = strength(0.1, "true inertia less the model's, reflected", like="extra_inertia_kg_m2")


class InertialCoupling(HiddenEffect):
    summary = "a joint's rotor also turns with the neighbouring joint nearer to the base"
    needs_neighbours = True

    ratio: float = strength(0.2, "turns after the gear per turn of the neighbour", lower=-inf)


def coupled_mass(inertias: Float, ratios: Float) -> Float:
    """Return the mass matrix of the rotors behind the sensors, symmetric and positive semidefinite, shape (n, n).

    The kinetic energy is the sum of B_i / 2 (dq_i + ratio_i dq_{i-1})^2 (De Luca and Book, 2016).
    """
    mass = np.diag(np.asarray(inertias, dtype=np.float64))
    for joint in range(1, len(inertias)):
        shared = inertias[joint] * ratios[joint]
        mass[joint - 1, joint - 1] += shared * ratios[joint]
        mass[joint - 1, joint] += shared
        mass[joint, joint - 1] += shared
    return mass
