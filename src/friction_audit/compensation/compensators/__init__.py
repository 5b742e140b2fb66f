"""The compensators there are, with their settings and their compiled laws."""

from types import NoneType
from typing import Any

import numpy as np

from friction_audit.compensation.compensators.energy import Coefficients, EnergyCompensator
from friction_audit.compensation.compensators.feedback import DisturbanceObserver, TorqueRegulation
from friction_audit.compensation.compensators.law import CompensatorKind, Guard, numbers_of
from friction_audit.compensation.compensators.model_based import (
    FixedCompensation,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
)

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

# In the order of the documentation, which is that of the codes in ``law``.
_KINDS: tuple[tuple[str, type[Any], str], ...] = (
    ("none", NoneType, "no compensation"),
    ("fixed", FixedCompensation, "given Coulomb and viscous friction; the true ones make it an oracle"),
    ("energy", EnergyCompensator, "the paper's: Coulomb and viscous friction from the energy of past cycles"),
    ("sigmoid", SigmoidCompensation, "model-based, Gaz sigmoidal (static): a sigmoid of the velocity"),
    ("lugre", LugreCompensation, "model-based, LuGre: bristles that bend and slip"),
    ("disturbance_observer", DisturbanceObserver, "friction observed as what the motor's dynamics do not explain"),
    ("torque_regulation", TorqueRegulation, "torque feedback that makes motor inertia and friction smaller"),
    ("joint_model", JointModelCompensation, "model-based: the terms of friction of a joint's model"),
)
COMPENSATORS = tuple(
    CompensatorKind(
        name=name,
        summary=summary,
        settings=settings,
        code=code,
        group=np.dtype([(one, "f8") for one in numbers_of(settings)]) if hasattr(settings, "guard") else None,
    )
    for code, (name, settings, summary) in enumerate(_KINDS)
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
