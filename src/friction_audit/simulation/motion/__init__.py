"""What a person, or the robot's commander, intends: motions of one joint, and the path of a hand.

The settings of a motion give it: ``settings.intend(ticks, dt, rng)`` is the intended position and velocity at the
ticks + 1 instants of the controller, from rest at 0; all that is drawn comes from ``rng``.
"""

from friction_audit.simulation.motion.periodic import Commanded, Sinusoid, intend_joints
from friction_audit.simulation.motion.strokes import HandPath, Prescribed, SlowSweep, StopAndGo, plan_hand

MotionSettings = StopAndGo | Sinusoid | SlowSweep | Commanded | Prescribed

__all__ = [
    "Commanded",
    "HandPath",
    "MotionSettings",
    "Prescribed",
    "Sinusoid",
    "SlowSweep",
    "StopAndGo",
    "intend_joints",
    "plan_hand",
]
