"""Backlash: a gap between motor and link that opens at every reversal, and the impact that closes it."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class Backlash:
    """A dead zone between motor and link with elastic contact at both flanks.

    Attributes:
        gap_rad: Full width of the gap. [rad]
        contact_compliance_rad_per_nm: Twist per torque in contact. [rad/(N m)]
        contact_damping_ratio: Damping ratio of the contact.
    """

    gap_rad: float = 0.0
    contact_compliance_rad_per_nm: float = 1e-4
    contact_damping_ratio: float = 0.2


@compiled()
def engaged(group: Any, stretch: float) -> float:  # noqa: ANN401 - a record of numbers
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
def contact_nm(group: Any, engaged_rad: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the elastic torque of the flanks, signed as the stretch that is left after the dead zone. [N m]"""
    return float(engaged_rad / group.contact_compliance_rad_per_nm)


@compiled()
def contact_damping_nms_per_rad(group: Any, inertia: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the damping of the flanks while they touch, which takes the energy of the impact. [N m s/rad]

    Args:
        group: A ``Backlash``.
        inertia: Inertia that the contact decelerates: the reduced one of both sides. [kg m^2]
    """
    return float(2.0 * group.contact_damping_ratio * math.sqrt(inertia / group.contact_compliance_rad_per_nm))


EFFECT = Effect(
    name="backlash",
    family="structure",
    summary="a gap between motor and link opens at every reversal",
    group=Backlash,
    strength="gap_rad",
    parameters=(
        Parameter(name="gap_rad", usual=2e-3, meaning="full width of the gap [rad]", high=0.1),
        Parameter(
            name="contact_compliance_rad_per_nm",
            usual=1e-4,
            meaning="twist per torque in contact [rad/(N m)]",
            low=1e-5,
            high=1e-2,
        ),
        Parameter(name="contact_damping_ratio", usual=0.2, meaning="damping ratio of the contact", high=2.0),
    ),
)
