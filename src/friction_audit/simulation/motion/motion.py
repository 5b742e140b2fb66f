"""Where the person, or the robot's commander, wants the joint to be."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Intention:
    """The intended motion at the controller's ticks t = k dt, k = 0..n.

    It starts at rest at 0. The shape is (n + 1,) for one joint and (n + 1, joints) for several.

    Attributes:
        position: Relative to the start. [rad]
        velocity: Its exact derivative. [rad/s]
    """

    position: Float
    velocity: Float


def tick_times(ticks: int, dt: float) -> Float:
    """Return the times of the controller's ticks, shape (ticks + 1,). [s]"""
    return np.arange(ticks + 1, dtype=np.float64) * dt


@dataclass(frozen=True, kw_only=True, slots=True)
class Motion:
    """One way of moving.

    Attributes:
        name: As in documentation and on the command line.
        summary: One line.
        settings: Frozen dataclass of its settings; made without arguments, it is the usual motion.
        intend: ``intend(settings, ticks, dt, rng)``, pure; ``ticks`` intervals of ``dt`` seconds.
    """

    name: str
    summary: str
    settings: type[Any]
    intend: Callable[..., Intention]
