"""Prescribed: given strokes from rest to rest, each with a smooth rise of the velocity, a constant speed and a fall."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.motion.motion import Intention, at_constant_speed, tick_times
from friction_audit.simulation.settings import require_positive, require_within

WHERE = "prescribed"
TOO_SHORT = 1e-9  # rounding of a way that is all rise and fall


class Stroke(NamedTuple):
    """A stroke and the rest after it."""

    way_rad: float  # signed; at least the speed times the ease [rad]
    speed_rad_s: float  # highest speed [rad/s]
    ease_s: float  # time of the rise of the velocity, and of its fall [s]
    rest_s: float  # rest afterwards [s]

    @property
    def moving_s(self) -> float:
        """How long it takes, without the rest. [s]"""
        return abs(self.way_rad) / self.speed_rad_s + self.ease_s


@dataclass(frozen=True, kw_only=True, slots=True)
class Prescribed:
    """Strokes one after the other.

    Raises:
        UsageError: If a number has the wrong sign or a way is shorter than rise and fall of its speed.
    """

    # in order: way [rad], highest speed [rad/s], ease [s], rest afterwards [s]
    strokes: tuple[Stroke, ...] = (Stroke(0.5, 0.5, 0.3, 0.5), Stroke(-0.5, 0.5, 0.3, 0.5)) * 4
    start_s: float = 0.5  # rest before the first one [s]

    def __post_init__(self) -> None:
        require_within(WHERE, 0.0, np.inf, start_s=self.start_s)
        for one in self.strokes:
            require_positive(WHERE, speed_rad_s=one.speed_rad_s, ease_s=one.ease_s)
            least = one.speed_rad_s * one.ease_s * (1.0 - TOO_SHORT)
            require_within(WHERE, 0.0, np.inf, rest_s=one.rest_s)
            require_within(WHERE, least, np.inf, way_rad=abs(one.way_rad))


def starts_of(settings: Prescribed) -> Float:
    """Return when each stroke begins, and when the last rest ends, shape (m + 1,). [s]"""
    lasts = [one.moving_s + one.rest_s for one in settings.strokes]
    return settings.start_s + np.concatenate([[0.0], np.cumsum(lasts)])


def intend(settings: Prescribed, ticks: int, dt: float, _: np.random.Generator) -> Intention:
    """Return the strokes; those that do not fit are cut off, after the last one there is rest."""
    way, speed, ease, _rest = np.array(settings.strokes).reshape(-1, 4).T
    return at_constant_speed(tick_times(ticks, dt), starts_of(settings)[:-1], way, speed, ease)
