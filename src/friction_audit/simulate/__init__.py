"""Settings and a seed -> JointLog with known truth."""

from friction_audit.simulate.arm import ArmSettings
from friction_audit.simulate.bench import BenchSettings
from friction_audit.simulate.dispatch import AnySettings, simulate
from friction_audit.simulate.effects import EFFECTS, Hidden
from friction_audit.simulate.hand import Hand
from friction_audit.simulate.operator import Operator
from friction_audit.simulate.panda_joint import HandGuidedPanda
from friction_audit.simulate.scenario import Scenario
from friction_audit.simulate.scenarios import SCENARIOS
from friction_audit.simulate.settings import IDEAL_SENSORS, PANDA_SENSORS, JointParameters, Sensors
from friction_audit.simulate.simulation import Motion, Simulation, Truth

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
