"""What the person, or the robot's commander, intends: one file per motion of one joint, and the path of a hand."""

from collections.abc import Callable
from typing import Any

import numpy as np

from friction_audit.simulation.motion import commanded, prescribed, sinusoid, slow_sweep, stop_and_go
from friction_audit.simulation.motion.commanded import Commanded, intend_joints
from friction_audit.simulation.motion.hand_path import HandMotion, HandPath, plan_hand
from friction_audit.simulation.motion.motion import Intention
from friction_audit.simulation.motion.prescribed import Prescribed
from friction_audit.simulation.motion.sinusoid import Sinusoid
from friction_audit.simulation.motion.slow_sweep import SlowSweep
from friction_audit.simulation.motion.stop_and_go import StopAndGo

MotionSettings = StopAndGo | Sinusoid | SlowSweep | Commanded | Prescribed
MOTIONS: dict[type[MotionSettings], Callable[[Any, int, float, np.random.Generator], Intention]] = {
    StopAndGo: stop_and_go.intend,
    Sinusoid: sinusoid.intend,
    SlowSweep: slow_sweep.intend,
    Commanded: commanded.intend,
    Prescribed: prescribed.intend,
}


def intend(settings: MotionSettings, ticks: int, dt: float, rng: np.random.Generator) -> Intention:
    """Return the intended motion of one joint.

    Args:
        settings: Which motion, and how.
        ticks: Number of the controller's intervals, n; at least 2.
        dt: Their length. [s]
        rng: Source of all that the motion draws; nothing else makes two results differ.

    Returns:
        Position and velocity at the n + 1 ticks, from rest at 0.
    """
    return MOTIONS[type(settings)](settings, ticks, dt, rng)


__all__ = [
    "MOTIONS",
    "Commanded",
    "HandMotion",
    "HandPath",
    "Intention",
    "MotionSettings",
    "Prescribed",
    "Sinusoid",
    "SlowSweep",
    "StopAndGo",
    "intend",
    "intend_joints",
    "plan_hand",
]
