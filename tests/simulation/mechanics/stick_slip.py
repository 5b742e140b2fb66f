"""A mass with dry friction on a hand's spring and damper, by SciPy with events: independent of the simulator."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from friction_audit.joint_log import Float

Course = Callable[[float], tuple[float, float]]
"""Intended position and velocity at a time."""


@dataclass(frozen=True, kw_only=True)
class DryMass:
    """Mass, spring, damper, and friction: level of sliding by speed, and level that holds at rest."""

    mass: float
    stiffness: float
    damping: float
    viscous: float
    slide: Callable[[float], float]
    hold: float
    course: Course

    def pull(self, t: float, q: float, v: float) -> float:
        """Return the torque of the hand."""
        place, speed = self.course(t)
        return self.stiffness * (place - q) + self.damping * (speed - v)


def solve(joint: DryMass, times: Float) -> tuple[Float, Float]:
    """Return position and velocity at the times, from rest at 0; every phase ends at an event that SciPy finds."""
    q, t, direction = 0.0, float(times[0]), 0
    out = np.zeros((2, len(times)))
    while t < times[-1]:
        if direction == 0:
            end, direction = _rest(joint, t, q, times[-1])
            inside = (times >= t) & (times <= end)
            out[0, inside], out[1, inside] = q, 0.0
        else:
            end, q = _slide(joint, t, q, direction, times, out)
            pull = joint.pull(end, q, 0.0)
            direction = int(np.sign(pull)) if abs(pull) > joint.hold else 0
        t = end
    return out[0], out[1]


def _rest(joint: DryMass, t: float, q: float, end: float) -> tuple[float, int]:
    """Return when the hand pulls a resting mass loose, and which way."""

    def spare(now: float, _: Float) -> float:
        return joint.hold - abs(joint.pull(now, q, 0.0))

    spare.terminal = True  # type: ignore[attr-defined]
    found: Any = solve_ivp(lambda *_: [0.0], (t, end), [0.0], max_step=2e-3, events=spare)
    if not len(found.t_events[0]):
        return end, 0
    loose = float(found.t_events[0][0])
    return loose, int(np.sign(joint.pull(loose, q, 0.0)))


def _slide(joint: DryMass, t: float, q: float, direction: int, times: Float, out: Float) -> tuple[float, float]:
    """Let the mass slide one way until it stops; return when and where, and fill in what lies between."""

    def slope(now: float, state: Float) -> list[float]:
        friction = direction * joint.slide(abs(state[1])) + joint.viscous * state[1]
        return [state[1], (joint.pull(now, state[0], state[1]) - friction) / joint.mass]

    def speed(now: float, state: Float) -> float:
        return float(direction * state[1]) if now > t + 1e-9 else 1.0

    speed.terminal, speed.direction = True, -1.0  # type: ignore[attr-defined]
    found: Any = solve_ivp(
        slope, (t, times[-1]), [q, 0.0], "DOP853", rtol=1e-11, atol=1e-13, max_step=0.02, events=speed,
        dense_output=True,
    )  # fmt: skip
    inside = (times >= t) & (times <= found.t[-1])
    out[:, inside] = found.sol(times[inside])
    return float(found.t[-1]), float(found.y[0, -1])
