"""The compensators there are, with their settings and their compiled laws."""

from typing import Any, get_args

from friction_audit.compensation.compensators.competitors import (
    DisturbanceObserver,
    FixedCompensation,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.compensation.compensators.law import Coefficients, EnergyCompensator, Guard

__all__ = [
    "COMPENSATORS",
    "Coefficients",
    "Compensator",
    "DisturbanceObserver",
    "EnergyCompensator",
    "FixedCompensation",
    "Guard",
    "JointModelCompensation",
    "LugreCompensation",
    "SigmoidCompensation",
    "TorqueRegulation",
    "guard_of",
]

# What runs on one joint; None where nothing does.
Compensator = (
    FixedCompensation
    | EnergyCompensator
    | SigmoidCompensation
    | LugreCompensation
    | DisturbanceObserver
    | TorqueRegulation
    | JointModelCompensation
)

# In the order of the documentation, which is that of the codes in ``law``, from 1 on.
COMPENSATORS: tuple[type[Any], ...] = get_args(Compensator)


def guard_of(compensator: Compensator | None) -> Guard:
    """Return passivity controller and limits of a compensator; where it has none, those that do nothing."""
    guard = compensator if isinstance(compensator, Guard) else getattr(compensator, "guard", None)
    return guard or Guard()
