"""The path of a hand that guides an arm: minimum-jerk strokes between via points, the orientation turning along."""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.motion.strokes import PEAK, REST_S, SHORTEST_S, course, latest, slope
from friction_audit.simulation.settings import Checked, positive, within

SHORTEST_M = 1e-3  # a hand that reaches less far stands still
SMALL_RAD = 1e-3  # below this angle, the series of the Jacobian are exact to rounding


@dataclass(frozen=True, kw_only=True, slots=True)
class HandPath(Checked):
    """Minimum-jerk strokes between via points drawn in a ball around the start, the orientation turning along.

    A person before the arm swings it to the sides further than up and down or to and fro. The defaults move all joints
    of a Panda that starts in its ready pose, the first one the least, and keep its limits.
    """

    reach_m: float = within(0.12, SHORTEST_M)  # radius of the ball of positions around the start [m]
    sideways: float = positive(2.5)  # the ball is so many times as wide along y, to the sides
    # radius of the ball of rotation vectors around the start orientation, below half a turn [rad]
    rotation_rad: float = within(0.6, 0.0, 3.14)
    # shortest and longest duration of a stroke, where neither the speed nor the reach cuts it [s]
    stroke_s: tuple[float, float] = within((0.9, 1.8), SHORTEST_S)
    # slowest and fastest peak speed; slower where the shortest stroke or the turn asks for it [m/s]
    speed_m_s: tuple[float, float] = positive((0.15, 0.6))
    turning_rad_s: float = positive(1.2)  # no stroke turns faster [rad/s]
    pause_s: tuple[float, float] = within((0.2, 0.7))  # shortest and longest pause between two strokes [s]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class HandMotion:
    """The intended motion of the hand at the controller's ticks, shape (n + 1, 3) each, in the world's axes."""

    position: Float  # offset from the start [m]
    rotation: Float  # rotation vector r; the orientation is exp(r) times the start orientation [rad]
    velocity: Float  # derivative of the position [m/s]
    angular: Float  # angular velocity [rad/s]


def plan_hand(settings: HandPath, ticks: int, dt: float, rng: np.random.Generator) -> HandMotion:
    """Draw the strokes that fit between a rest at the start and a rest at the end; at rest if not one fits."""
    strokes, t = _draw_strokes(settings, ticks * dt, rng), np.arange(ticks + 1, dtype=np.float64) * dt
    current = strokes[latest(strokes[:, 0], t)]
    start, lasts, origin, change = np.split(current, [1, 2, 8], axis=1)
    x = np.clip((t[:, np.newaxis] - start) / lasts, 0.0, 1.0)
    position, rotation = np.hsplit(origin + course(x) * change, 2)
    velocity, turning = np.hsplit(slope(x) / lasts * change, 2)
    angular = angular_velocity(rotation, turning)
    return HandMotion(position=position, rotation=rotation, velocity=velocity, angular=angular)


def angular_velocity(rotation: Float, derivative: Float) -> Float:
    """Return the angular velocity in the world's axes, by the left Jacobian of the rotation group.

    Of rotation vectors [rad] and their derivatives by time [rad/s], shape (n, 3) each.
    """
    angle = np.linalg.norm(rotation, axis=1)
    safe = np.maximum(angle, SMALL_RAD)
    first = np.where(angle > SMALL_RAD, 2 * (np.sin(safe / 2) / safe) ** 2, 0.5 - angle**2 / 24)
    second = np.where(angle > SMALL_RAD, (safe - np.sin(safe)) / safe**3, 1 / 6 - angle**2 / 120)
    across = np.cross(rotation, derivative)
    result: Float = derivative + first[:, np.newaxis] * across + second[:, np.newaxis] * np.cross(rotation, across)
    return result


def _draw_strokes(settings: HandPath, duration_s: float, rng: np.random.Generator) -> Float:
    """Draw a rest and strokes, shape (m, 14): start [s], duration [s], origin and change of the pose [m, rad]."""
    rows = [np.array([0.0, REST_S, *np.zeros(12)])]
    start, pose = REST_S, np.zeros(6)
    while True:
        lasts, change = _draw_stroke(settings, pose, rng)
        if start + lasts > duration_s - REST_S:
            break
        rows.append(np.concatenate(([start, lasts], pose, change)))
        start += lasts + rng.uniform(*settings.pause_s)
        pose = pose + change
    return np.array(rows)


def _draw_stroke(settings: HandPath, pose: Float, rng: np.random.Generator) -> tuple[float, Float]:
    """Draw duration [s] and change, shape (6,) [m, rad], of a stroke as far as it gets towards a via point.

    The via point is at least half the reach away.
    """
    while True:
        place = settings.reach_m * _draw_in_ball(rng) * (1.0, settings.sideways, 1.0)
        if np.linalg.norm(place - pose[:3]) >= settings.reach_m / 2:
            break
    change = np.concatenate((place, settings.rotation_rad * _draw_in_ball(rng))) - pose
    distance = float(np.linalg.norm(change[:3]))
    speed = float(np.exp(rng.uniform(*np.log(settings.speed_m_s))))
    length = min(distance, speed * rng.uniform(*settings.stroke_s) / PEAK)
    change *= length / distance
    turn = float(np.linalg.norm(change[3:]))
    return max(PEAK * length / speed, PEAK * turn / settings.turning_rad_s, settings.stroke_s[0]), change


def _draw_in_ball(rng: np.random.Generator) -> Float:
    """Draw a point of the unit ball, evenly distributed, shape (3,)."""
    direction = rng.standard_normal(3)
    point: Float = direction / np.linalg.norm(direction) * rng.random() ** (1 / 3)
    return point
