"""Settings and a seed -> JointLog with known truth."""

from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.dispatch import AnySettings, simulate
from friction_audit.simulation.effects import EFFECTS, Hidden
from friction_audit.simulation.operator import Hand, Operator
from friction_audit.simulation.panda_joint import HandGuidedPanda
from friction_audit.simulation.scenarios import SCENARIOS, Scenario
from friction_audit.simulation.settings import IDEAL_SENSORS, PANDA_SENSORS, JointParameters, Sensors
from friction_audit.simulation.simulation import Motion, Simulation, Truth

__all__ = [
    "EFFECTS",
    "IDEAL_SENSORS",
    "PANDA_SENSORS",
    "SCENARIOS",
    "AnySettings",
    "ArmSettings",
    "BenchSettings",
    "Hand",
    "HandGuidedPanda",
    "Hidden",
    "JointParameters",
    "Motion",
    "Operator",
    "Scenario",
    "Sensors",
    "Simulation",
    "Truth",
    "simulate",
]
