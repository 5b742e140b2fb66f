"""Joint elasticity: between motor and link the gear twists."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.errors import UsageError
from friction_audit.simulation.effects.effect import Effect, Parameter

LINEAR, HARDENING = range(2)

LEAST_COMPLIANCE = 1e-5
"""A stiffer gear rings faster than the integration can follow, and is rigid for all that a log shows. [rad/(N m)]"""

KNEE_NM = 1.0
"""Torque around which a strain-wave gear turns from soft to stiff. [N m]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class JointElasticity:
    """A spring and a damper between motor and link.

    With the usual 1e-3 rad/(N m), a motor of 0.3 kg m^2 rings at 9.2 Hz against a link held fast and at 13.0 Hz
    against 0.3 kg m^2 on the hand's side.

    Attributes:
        compliance_rad_per_nm: Twist per torque; of the hardening form far from zero torque. [rad/(N m)]
        damping_ratio: Of the ringing.
        form: Index into the forms of the effect.

    Raises:
        UsageError: If the joint is neither rigid nor soft enough.
    """

    compliance_rad_per_nm: float = 0.0
    damping_ratio: float = 0.03
    form: int = LINEAR

    def __post_init__(self) -> None:
        """Check the compliance."""
        if 0.0 < self.compliance_rad_per_nm < LEAST_COMPLIANCE:
            raise UsageError(
                f"joint_elasticity: compliance_rad_per_nm {self.compliance_rad_per_nm:g}: expected 0, a rigid joint, "
                f"or at least {LEAST_COMPLIANCE:g}"
            )


@compiled()
def torque_nm(group: Any, stretch: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the torque of the spring, signed as the stretch; 0 for a rigid joint, which does not twist. [N m]

    Linear after Spong (1987); hardening as a strain-wave gear, half as stiff near zero torque (Tuttle and Seering 1996;
    the smooth transition after Ruderman 2012). Conservative in both forms.

    Args:
        group: A ``JointElasticity``.
        stretch: Motor position less link position, theta - q. [rad]
    """
    compliance = group.compliance_rad_per_nm
    if compliance == 0.0:
        return 0.0
    if group.form == HARDENING:
        knee = KNEE_NM * compliance
        stretch -= knee * math.tanh(0.5 * stretch / knee)
    return float(stretch / compliance)


@compiled()
def damping_nms_per_rad(group: Any, inertia: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the damping between motor and link that gives the damping ratio; 0 for a rigid joint. [N m s/rad]

    Args:
        group: A ``JointElasticity``.
        inertia: Inertia that rings on the spring: the reduced one of both sides. [kg m^2]
    """
    if group.compliance_rad_per_nm == 0.0:
        return 0.0
    return float(2.0 * group.damping_ratio * math.sqrt(inertia / group.compliance_rad_per_nm))


EFFECT = Effect(
    name="joint_elasticity",
    family="structure",
    summary="the gear twists between motor and link",
    group=JointElasticity,
    strength="compliance_rad_per_nm",
    parameters=(
        Parameter(name="compliance_rad_per_nm", usual=1e-3, meaning="twist per torque [rad/(N m)]", high=0.1),
        Parameter(name="damping_ratio", usual=0.03, meaning="damping ratio of the ringing", high=2.0),
    ),
    forms=("linear", "hardening"),
)
