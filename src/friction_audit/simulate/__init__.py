"""Settings and a seed -> JointLog with known truth."""

from friction_audit.simulate.joint import Simulation, Truth, simulate_joint
from friction_audit.simulate.panda import HandGuidedPanda, PandaSimulation, simulate_hand_guided_panda
from friction_audit.simulate.settings import (
    IDEAL_SENSORS,
    PANDA_SENSORS,
    Compensation,
    JointParameters,
    JointSettings,
    Operator,
    Sensors,
)

__all__ = [
    "IDEAL_SENSORS",
    "PANDA_SENSORS",
    "Compensation",
    "HandGuidedPanda",
    "JointParameters",
    "JointSettings",
    "Operator",
    "PandaSimulation",
    "Sensors",
    "Simulation",
    "Truth",
    "simulate_hand_guided_panda",
    "simulate_joint",
]
