"""Names of the compensators' settings; each is made in a file of ``replay.compensators``."""

from friction_audit.replay.compensators import (
    Coefficients,
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    FixedCompensation,
    Guard,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.replay.compensators.energy import LONGEST_WINDOW, MODELS

__all__ = [
    "LONGEST_WINDOW",
    "MODELS",
    "Coefficients",
    "Compensator",
    "DisturbanceObserver",
    "EnergyCompensator",
    "FixedCompensation",
    "Guard",
    "LugreCompensation",
    "SigmoidCompensation",
    "TorqueRegulation",
]
