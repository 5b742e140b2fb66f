"""Slow effects and events: warm-up, changes of friction, contacts, and a compensator that is not logged."""

import math

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, must, number, strength

AMBIENT, SELF_HEATING = range(2)


class WarmUp(HiddenEffect):
    """Friction that falls with the temperature; the warmth is the normalised temperature: 0 cold, 1 warm."""

    summary = "friction falls while the joint gets warm"
    forms = ("ambient", "self_heating")

    reduction: float = strength(0.5, "share of viscous friction lost when warm", upper=0.9)
    coulomb_ratio: float = number(0.5, "Coulomb friction lost, as a share of that", upper=1.0)
    time_s: float = number(60.0, "thermal time constant", like="warm_up_time_s")
    power_w: float = number(0.2, "friction power that keeps it warm, self-heating", "W", lower=1e-06)
    cold_c: float = number(25.0, "temperature when cold", "degC", lower=-50.0, upper=100.0)
    rise_k: float = number(15.0, "rise of the temperature when warm", "K", upper=100.0)


@compiled(inline=True)
def warm_up_advance(group: Record, warmth: float, friction_power_w: float, h: float) -> float:
    """Return the warmth after a step h, exact at constant power; self-heating (Simoni et al. 2015) may exceed 1."""
    target = friction_power_w / group.power_w if group.form == SELF_HEATING else 1.0
    return float(warmth - (target - warmth) * math.expm1(-h / group.time_s))


@compiled(inline=True)
def warm_up_coulomb_factor(group: Record, warmth: float) -> float:
    """Return the Coulomb friction relative to the cold joint: about linear in the temperature, always positive."""
    lost = group.reduction * group.coulomb_ratio
    return float(1.0 / (1.0 + warmth * lost / (1.0 - lost)))


@compiled(inline=True)
def warm_up_viscous_factor(group: Record, warmth: float) -> float:
    """Return the viscous friction relative to the cold joint: exponential in the temperature (Reynolds 1886)."""
    return float((1.0 - group.reduction) ** warmth)


ABRUPT, RAMP, SETTLING = range(3)


class FrictionStep(HiddenEffect):
    summary = "friction changes once, at a moment of the recording"
    forms = ("abrupt", "ramp", "settling")

    change: float = strength(0.5, "change of Coulomb friction, as a share of it", lower=-0.95)
    viscous_ratio: float = number(1.0, "change of viscous friction, as a share of that", upper=1.0)
    at_share: float = number(0.5, "when, as a share of the recording", upper=1.0)
    length_s: float = number(5.0, "length of the ramp, time constant of settling", "s", lower=0.001)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        coulomb, viscous, time, length = values.values()
        joint = setting.joint
        must(coulomb != 0.0 and joint.coulomb_nm > 0.0, "its step is a share of the Coulomb friction")
        change = coulomb / joint.coulomb_nm
        by_viscous = viscous / joint.viscous_nms_per_rad if joint.viscous_nms_per_rad > 0.0 else 0.0
        given: Given = {"change": change, "viscous_ratio": by_viscous / change}
        if length == 0.0:
            return {**given, "at_share": time / setting.duration_s, "form": "abrupt"}
        begin = (time - 0.5 * length) / setting.duration_s
        return {**given, "at_share": begin, "length_s": length, "form": "ramp"}


@compiled(inline=True)
def friction_step_factor(group: Record, ratio: float, t: float, duration: float) -> float:
    """Return a coefficient relative to that before the step, always positive; the ratio scales the change."""
    since, done = t - group.at_share * duration, 1.0
    if since < 0.0:
        done = 0.0
    elif group.form == RAMP:
        done = min(1.0, since / group.length_s)
    elif group.form == SETTLING:
        done = -math.expm1(-since / group.length_s)
    return float(1.0 + group.change * ratio * done)


KNOCK, DRAG, STEP = range(3)
SHORTEST_S = 0.05
LONGEST_S = 0.5
LENGTH_SPREAD = 0.5
TAIL_EXPONENT = 2.0
LARGEST = 5.0
DRAG_SPEED_RAD_S = 0.05


class ContactEvent(HiddenEffect):
    summary = "something touches the link side of the joint now and then"
    forms = ("knock", "drag", "step")

    torque_nm: float = strength(1.0, "median size of an event", "N m")
    per_minute: float = number(6.0, "events in a minute", upper=600.0)
    length_s: float = number(0.2, "median length", "s", lower=0.05, upper=0.5)


def draw_events(group: ContactEvent, duration_s: float, rng: np.random.Generator) -> Float:
    """Draw the events of a recording: at least one if there are any, all of them over before the end.

    Times are uniform, their number is Poisson. Lengths spread about their median within 50 to 500 ms. Sizes have a
    heavy tail (Pareto about their median, at most five times it) and either sign.

    Returns start, length and size, by start, shape (m, 3). [s, s, N m]
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


@compiled(inline=True)
def contact_event_nm(group: Record, events: Float, t: float, velocity: float) -> float:
    """Return the torque of the events; a knock is half a sine, a step is constant, a drag is dissipative. [N m]"""
    torque = 0.0
    k = np.searchsorted(events[:, 0], t, side="right") - 1  # the last that has begun
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


SMOOTH, DEAD_BAND, SIGMOID = range(3)
SKEW = 0.2


class UnloggedCompensation(HiddenEffect):
    summary = "a friction compensator was active that the log does not contain"
    forms = ("smooth", "dead_band", "sigmoid")

    share: float = strength(0.7, "share of the friction compensated", upper=1.2)
    coulomb_nm: float = number(0.2, "Coulomb friction it believes in", "N m")
    viscous_nms_per_rad: float = number(0.05, "viscous coefficient it believes in", "N m s/rad")
    width_rad_s: float = number(0.05, "speed up to which it holds back", like="unlogged_width_rad_s")

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        torque, width, skew, form = values.values()
        must(skew == 0.0, "its sigmoid has one shift")
        friction: Given = {"share": 1.0, "coulomb_nm": torque, "viscous_nms_per_rad": 0.0, "width_rad_s": width}
        return {**friction, "form": "dead_band" if round(form) else "smooth"}


@compiled(inline=True)
def unlogged_nm(group: Record, velocity: float) -> float:
    """Return the torque of the compensator, in the direction of the velocity. [N m]

    It is not passive: where it exceeds the joint's own friction it drives the joint. The sigmoid is that of Gaz et al.
    (2019), shifted through the origin: phi1 is twice the Coulomb friction, phi2 one over the width; phi2 phi3 is that
    of the published joint 1, so that the plateaus differ by a fifth. As tanh it does not overflow.
    """
    if group.form == SIGMOID:
        shifted = math.tanh(0.5 * (velocity / group.width_rad_s + SKEW))
        return float(group.share * (group.coulomb_nm * (shifted - math.tanh(0.5 * SKEW))))
    if group.form == DEAD_BAND:
        if abs(velocity) <= group.width_rad_s:
            return 0.0
        coulomb = math.copysign(group.coulomb_nm, velocity)
    else:
        coulomb = group.coulomb_nm * math.tanh(velocity / group.width_rad_s)
    return float(group.share * (coulomb + group.viscous_nms_per_rad * velocity))
