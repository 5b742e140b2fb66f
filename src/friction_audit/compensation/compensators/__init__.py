"""The compensators there are: one file each, with its settings and its compiled law."""

from types import NoneType

from friction_audit.compensation.compensators import (
    disturbance_observer,
    energy,
    fixed,
    joint_model,
    lugre,
    sigmoid,
    torque_regulation,
)
from friction_audit.compensation.compensators.disturbance_observer import DisturbanceObserver
from friction_audit.compensation.compensators.energy import Coefficients, EnergyCompensator
from friction_audit.compensation.compensators.fixed import FixedCompensation
from friction_audit.compensation.compensators.joint_model import JointModelCompensation
from friction_audit.compensation.compensators.law import NONE, CompensatorKind, Guard
from friction_audit.compensation.compensators.lugre import LugreCompensation
from friction_audit.compensation.compensators.sigmoid import SigmoidCompensation
from friction_audit.compensation.compensators.torque_regulation import TorqueRegulation

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
    "kind_of",
]

# In the order of the documentation.
COMPENSATORS: tuple[CompensatorKind, ...] = (
    CompensatorKind(name="none", summary="no compensation", settings=NoneType, code=NONE),
    fixed.COMPENSATOR,
    energy.COMPENSATOR,
    sigmoid.COMPENSATOR,
    lugre.COMPENSATOR,
    disturbance_observer.COMPENSATOR,
    torque_regulation.COMPENSATOR,
    joint_model.COMPENSATOR,
)

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


def kind_of(compensator: Compensator | None) -> CompensatorKind:
    """Return the kind of a compensator."""
    return next(kind for kind in COMPENSATORS if isinstance(compensator, kind.settings))


def guard_of(compensator: Compensator | None) -> Guard:
    """Return passivity controller and limits of a compensator; where it has none, those that do nothing."""
    guard = compensator if isinstance(compensator, Guard) else getattr(compensator, "guard", None)
    return guard or Guard()
