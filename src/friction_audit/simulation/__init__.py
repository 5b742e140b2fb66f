"""Settings and a seed -> JointLog with known truth."""

from friction_audit.simulation.arm import ArmSettings, Hand
from friction_audit.simulation.bench import BenchSettings, HandGuidedPanda, Operator
from friction_audit.simulation.effects import EFFECTS, Hidden
from friction_audit.simulation.scenarios import SCENARIOS, simulate
from friction_audit.simulation.settings import (
    IDEAL_SENSORS,
    PANDA_SENSORS,
    JointParameters,
    Sensors,
    Simulation,
    TrueMotion,
)

__all__ = [
    "EFFECTS",
    "IDEAL_SENSORS",
    "PANDA_SENSORS",
    "SCENARIOS",
    "ArmSettings",
    "BenchSettings",
    "Hand",
    "HandGuidedPanda",
    "Hidden",
    "JointParameters",
    "Operator",
    "Sensors",
    "Simulation",
    "TrueMotion",
    "simulate",
]
