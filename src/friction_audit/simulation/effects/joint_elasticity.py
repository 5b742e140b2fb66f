"""Joint elasticity: between motor and link the gear twists."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.errors import UsageError
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength

LINEAR, HARDENING = range(2)

# A stiffer gear rings faster than the integration can follow, and is rigid for all that a log shows. [rad/(N m)]
LEAST_COMPLIANCE = 1e-5

KNEE_NM = 1.0  # torque around which a strain-wave gear turns from soft to stiff. [N m]
SMALL_NM = 0.02  # a spring that stiffens at a smaller torque is a linear one


@dataclass(frozen=True, kw_only=True, slots=True)
class JointElasticity(HiddenEffect):
    """A spring and a damper between motor and link.

    With the usual 1e-3 rad/(N m), a motor of 0.3 kg m^2 rings at 9.2 Hz against a link held fast and at 13.0 Hz
    against 0.3 kg m^2 on the hand's side.
    """

    summary = "the gear twists between motor and link"
    forms = ("linear", "hardening")

    compliance_rad_per_nm: float = strength(0.001, "twist per torque", "rad/(N m)", upper=0.1)
    damping_ratio: float = number(0.03, "damping ratio of the ringing", like="damping_ratio")
    form: int = LINEAR

    def __post_init__(self) -> None:
        if 0.0 < self.compliance_rad_per_nm < LEAST_COMPLIANCE:
            raise UsageError(
                f"joint_elasticity: compliance_rad_per_nm {self.compliance_rad_per_nm:g}: expected 0, a rigid joint, "
                f"or at least {LEAST_COMPLIANCE:g}"
            )

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        must(values["soft_nm"] <= SMALL_NM, "its spring stiffens as a hyperbolic tangent, not evenly up to a torque")
        must(values["far_share"] >= 1.0 - ALIKE, "all inertia is on the link side of its spring")
        damping_ratio = setting.with_both_sides_free(values["damping_ratio"])
        compliance = values["compliance_rad_per_nm"]
        return {"compliance_rad_per_nm": compliance, "damping_ratio": damping_ratio, "form": "linear"}


@compiled()
def torque_nm(group: Record, stretch: float) -> float:
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


@compiled()
def damping_nms_per_rad(group: Record, inertia: float) -> float:
    """Return the damping between motor and link that gives the damping ratio; 0 for a rigid joint. [N m s/rad]

    Inertia: the reduced one of both sides. [kg m^2]
    """
    if group.compliance_rad_per_nm == 0.0:
        return 0.0
    return float(2.0 * group.damping_ratio * math.sqrt(inertia / group.compliance_rad_per_nm))
