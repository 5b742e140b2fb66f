"""What a person, or the robot's commander, intends, and the minimum-jerk course (Flash and Hogan, 1985) of strokes."""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float

PEAK = 1.875  # steepest slope of the course, half-way: the peak speed of a stroke of length 1 in time 1
REST_S = 0.5  # rest before the first stroke of a motion and after the last
SHORTEST_S = 0.01  # no person starts a stroke and ends it in less


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Intention:
    """The intended motion at the controller's ticks t = k dt, k = 0..n, from rest at 0.

    The shape is (n + 1,) for one joint and (n + 1, joints) for several.
    """

    position: Float  # relative to the start [rad]
    velocity: Float  # its exact derivative [rad/s]


def tick_times(ticks: int, dt: float) -> Float:
    """Return the times of the controller's ticks, shape (ticks + 1,). [s]"""
    return np.arange(ticks + 1, dtype=np.float64) * dt


def course(x: Float) -> Float:
    """Return the share of the way covered at the share x of the time, in [0, 1]."""
    return x * x * x * (10.0 + x * (6.0 * x - 15.0))


def slope(x: Float) -> Float:
    """Return the derivative of the course at x in [0, 1]."""
    return 30.0 * x * x * (1.0 - x) * (1.0 - x)


def area(x: Float) -> Float:
    """Return the integral from 0 to x of the course, which stays 0 below 0 and 1 above 1."""
    inside = np.clip(x, 0.0, 1.0)
    return inside**4 * (2.5 + inside * (inside - 3.0)) + np.maximum(x - 1.0, 0.0)


def rising(x: Float) -> Float:
    """Return the course for any x: 0 below 0 and 1 above 1."""
    return course(np.clip(x, 0.0, 1.0))


def latest(start_s: Float, t: Float) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    """Return for every time the last of the strokes that has begun, the first before any has; shape of t."""
    return np.maximum(np.searchsorted(start_s, t, side="right") - 1, 0)


def at_constant_speed(t: Float, start_s: Float, way: Float, speed: Float, ease_s: Float) -> Intention:
    """Return strokes of a constant speed, each with a smooth rise of the velocity and a fall; arrays one per stroke."""
    if not len(start_s):
        return Intention(position=np.zeros_like(t), velocity=np.zeros_like(t))
    stroke = latest(start_s, t)
    rise = (t - start_s[stroke]) / ease_s[stroke]
    fall = rise - (np.abs(way) / speed / ease_s)[stroke]
    signed, origin = np.copysign(speed, way)[stroke], (np.cumsum(way) - way)[stroke]
    position = origin + signed * ease_s[stroke] * (area(rise) - area(fall))
    return Intention(position=position, velocity=signed * (rising(rise) - rising(fall)))
