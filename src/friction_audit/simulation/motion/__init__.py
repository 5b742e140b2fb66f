"""What the person, or the robot's commander, intends: one file per motion.

A motion of one joint belongs to ``MOTIONS``; the path of a hand that guides a whole arm is in ``hand_path``.
"""

import numpy as np

from friction_audit.simulation.motion import commanded, sinusoid, slow_sweep, stop_and_go
from friction_audit.simulation.motion.commanded import Commanded, intend_joints
from friction_audit.simulation.motion.hand_path import HandMotion, HandPath, plan_hand
from friction_audit.simulation.motion.motion import Intention, Motion
from friction_audit.simulation.motion.sinusoid import Sinusoid
from friction_audit.simulation.motion.slow_sweep import SlowSweep
from friction_audit.simulation.motion.stop_and_go import StopAndGo

MOTIONS: tuple[Motion, ...] = (stop_and_go.MOTION, sinusoid.MOTION, slow_sweep.MOTION, commanded.MOTION)

MotionSettings = StopAndGo | Sinusoid | SlowSweep | Commanded
"""Settings of any motion of one joint."""


def intend(settings: MotionSettings, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return the intended motion of one joint.

    Args:
        settings: Which motion, and how.
        ticks: Number of the controller's intervals, n; at least 2.
        dt: Their length. [s]
        rng: Source of whatever the motion draws; nothing else makes two results differ.

    Returns:
        Position and velocity at the n + 1 ticks, from rest at 0.
    """
    (motion,) = (motion for motion in MOTIONS if isinstance(settings, motion.settings))
    return motion.intend(settings, ticks, dt, rng)


__all__ = [
    "MOTIONS",
    "Commanded",
    "HandMotion",
    "HandPath",
    "Intention",
    "Motion",
    "MotionSettings",
    "Sinusoid",
    "SlowSweep",
    "StopAndGo",
    "intend",
    "intend_joints",
    "plan_hand",
]
