"""The compensators there are, with their settings and their compiled laws."""

from types import NoneType
from typing import Any, NamedTuple

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
    "kind_of",
]


class CompensatorKind(NamedTuple):
    """One kind of compensator."""

    name: str  # as in options, tables and documentation; also the field of the records that holds its numbers
    settings: type[Any]  # frozen dataclass of its settings; NoneType where nothing runs
    summary: str  # one line


# In the order of the documentation, which is that of the codes in ``law``.
COMPENSATORS = tuple(
    CompensatorKind(*one)
    for one in (
        ("none", NoneType, "no compensation"),
        ("fixed", FixedCompensation, "given Coulomb and viscous friction; the true ones make it an oracle"),
        ("energy", EnergyCompensator, "the paper's: Coulomb and viscous friction from the energy of past cycles"),
        ("sigmoid", SigmoidCompensation, "model-based, Gaz sigmoidal (static): a sigmoid of the velocity"),
        ("lugre", LugreCompensation, "model-based, LuGre: bristles that bend and slip"),
        ("disturbance_observer", DisturbanceObserver, "friction observed as what the motor's dynamics do not explain"),
        ("torque_regulation", TorqueRegulation, "torque feedback that makes motor inertia and friction smaller"),
        ("joint_model", JointModelCompensation, "model-based: the terms of friction of a joint's model"),
    )
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
