"""The compensators there are: one file each, with its settings and its compiled law."""

from types import NoneType
from typing import Any

from friction_audit.compensation.compensators import (
    disturbance_observer,
    joint_model,
    lugre,
    sigmoid,
    torque_regulation,
)
from friction_audit.compensation.compensators.disturbance_observer import DisturbanceObserver
from friction_audit.compensation.compensators.energy import Coefficients, EnergyCompensator
from friction_audit.compensation.compensators.fixed import FixedCompensation
from friction_audit.compensation.compensators.joint_model import JointModelCompensation
from friction_audit.compensation.compensators.law import CompensatorKind, Guard
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

# In the order of the documentation, which is that of the codes in ``law``.
_KINDS: tuple[tuple[str, type[Any], Any, str], ...] = (
    ("none", NoneType, None, "no compensation"),
    ("fixed", FixedCompensation, None, "given Coulomb and viscous friction; the true ones make it an oracle"),
    ("energy", EnergyCompensator, None, "the paper's: Coulomb and viscous friction from the energy of past cycles"),
    ("sigmoid", SigmoidCompensation, sigmoid.GROUP, "model-based, Gaz sigmoidal (static): a sigmoid of the velocity"),
    ("lugre", LugreCompensation, lugre.GROUP, "model-based, LuGre: bristles that bend and slip"),
    (
        "disturbance_observer",
        DisturbanceObserver,
        disturbance_observer.GROUP,
        "friction observed as what the motor's dynamics do not explain",
    ),
    (
        "torque_regulation",
        TorqueRegulation,
        torque_regulation.GROUP,
        "torque feedback that makes motor inertia and friction smaller",
    ),
    ("joint_model", JointModelCompensation, joint_model.GROUP, "model-based: the terms of friction of a joint's model"),
)
COMPENSATORS = tuple(
    CompensatorKind(name=name, summary=summary, settings=settings, code=code, group=group)
    for code, (name, settings, group, summary) in enumerate(_KINDS)
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
