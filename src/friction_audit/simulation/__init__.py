"""Settings and a seed -> JointLog with known truth."""

from friction_audit.simulation.arm import ArmSettings as ArmSettings, Hand as Hand
from friction_audit.simulation.bench import (
    BenchSettings as BenchSettings,
    HandGuidedPanda as HandGuidedPanda,
    Operator as Operator,
)
from friction_audit.simulation.effects import EFFECTS as EFFECTS, Hidden as Hidden
from friction_audit.simulation.scenarios import SCENARIOS as SCENARIOS, simulate as simulate
from friction_audit.simulation.settings import (
    IDEAL_SENSORS as IDEAL_SENSORS,
    PANDA_SENSORS as PANDA_SENSORS,
    JointParameters as JointParameters,
    Sensors as Sensors,
    Simulation as Simulation,
    TrueMotion as TrueMotion,
)
