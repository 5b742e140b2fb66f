"""Contact event: for a moment something touches the joint behind its torque sensor."""

import math
from dataclasses import dataclass

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import HiddenEffect, number, strength

KNOCK, DRAG, STEP = range(3)

SHORTEST_S = 0.05
LONGEST_S = 0.5
LENGTH_SPREAD = 0.5
TAIL_EXPONENT = 2.0
LARGEST = 5.0
DRAG_SPEED_RAD_S = 0.05


@dataclass(frozen=True, kw_only=True, slots=True)
class ContactEvent(HiddenEffect):
    """Short torques that are not the joint's own."""

    summary = "something touches the link side of the joint now and then"
    forms = ("knock", "drag", "step")

    torque_nm: float = strength(1.0, "median size of an event", "N m")
    per_minute: float = number(6.0, "events in a minute", upper=600.0)
    length_s: float = number(0.2, "median length", "s", lower=0.05, upper=0.5)
    form: int = KNOCK


def draw_events(group: ContactEvent, duration_s: float, rng: np.random.Generator) -> Float:
    """Draw the events of a recording: at least one if there are any, all of them over before the end.

    Times are uniform, their number is Poisson. Lengths spread about their median within 50 to 500 ms. Sizes have a
    heavy tail (Pareto about their median, at most five times it) and either sign.

    Returns:
        Start, length and size, by start, shape (m, 3). [s, s, N m]
    """
    expected = group.per_minute * duration_s / 60.0
    if group.torque_nm == 0.0 or expected == 0.0:
        return np.zeros((0, 3))
    count = max(1, rng.poisson(expected))
    length = np.clip(group.length_s * np.exp(LENGTH_SPREAD * rng.standard_normal(count)), SHORTEST_S, LONGEST_S)
    length = np.minimum(length, duration_s)
    start = rng.random(count) * (duration_s - length)
    size = np.minimum((2.0 * (1.0 - rng.random(count))) ** (-1.0 / TAIL_EXPONENT), LARGEST)
    events = np.column_stack([start, length, group.torque_nm * size * rng.choice([-1.0, 1.0], count)])
    return events[np.argsort(start)]


@compiled()
def count_begun(events: Float, t: float) -> int:
    """Return how many events began before or at t, by bisection."""
    low, high = 0, len(events)
    while low < high:
        middle = (low + high) // 2
        if events[middle, 0] <= t:
            low = middle + 1
        else:
            high = middle
    return low


@compiled()
def torque_nm(group: Record, events: Float, t: float, velocity: float) -> float:
    """Return the torque that the events exert in the positive direction of the joint. [N m]

    A knock is half a sine, a step is a load that is there and gone; both can drive the joint. A drag only takes energy:
    against the motion, viscous when slow and Coulomb when fast.
    """
    torque = 0.0
    k = count_begun(events, t) - 1
    while k >= 0 and events[k, 0] > t - LONGEST_S:
        share = (t - events[k, 0]) / events[k, 1]
        if share < 1.0:
            size = events[k, 2]
            if group.form == KNOCK:
                torque += size * math.sin(math.pi * share)
            elif group.form == DRAG:
                torque -= abs(size) * velocity / (abs(velocity) + DRAG_SPEED_RAD_S)
            else:
                torque += size
        k -= 1
    return torque
