"""Effects of load and position: friction and torques that depend on the transmitted torque and on the position."""

import math
from math import inf

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import (
    ALIKE,
    Given,
    HiddenEffect,
    Setting,
    Values,
    alike,
    must,
    number,
    strength,
)

LINEAR_LOAD, QUADRATIC_LOAD, BACKDRIVE = range(3)
REFERENCE_NM = 10.0  # load at which the quadratic form equals the linear one. [N m]

BACKDRIVE_EXCESS = 0.5  # relative increase of the loss where the link drives the motor; a decrease otherwise


class LoadDependentFriction(HiddenEffect):
    summary = "friction grows with the torque that the gear transmits"
    forms = ("linear", "quadratic", "backdrive")

    share: float = strength(0.06, "share of the transmitted torque that is lost", upper=1.0)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        share, by_power, exponent, directed, static = values.values()
        must(round(static) == 0, "its load is all that goes through the gear, and not the weight alone")
        must(by_power == 0.0 or round(directed) == 0, "its loss by the direction of the power is half of the mean")
        must(alike(exponent, 1.0) or alike(exponent, 2.0), f"its exponents are 1 and 2, not {exponent:g}")
        if alike(exponent, 1.0):
            return {"share": share, "form": "linear"}
        return {"share": share * REFERENCE_NM, "form": "quadratic"}


@compiled(inline=True)
def load_friction_nm(group: Record, load_nm: float, power_w: float) -> float:
    """Return the friction that the load adds to the Coulomb friction (not negative, so passive). [N m]

    Linear after Bittencourt and Gunnarsson, Static friction in a robot joint (2012); quadratic after Duclusaud et al.,
    Extended friction models for the physics simulation of servo actuators (2025); backdrive after Wang and Kim,
    Directional efficiency in geared transmissions (2015): the losses are larger where the link drives the motor. There
    the power through the sensor into the motor's side is positive.
    """
    load = abs(load_nm)
    if group.form == QUADRATIC_LOAD:
        return float(group.share * load * load / REFERENCE_NM)
    excess = BACKDRIVE_EXCESS * np.sign(power_w) if group.form == BACKDRIVE else 0.0
    return float(group.share * load * (1.0 + excess))


SINUSOID, HARMONICS, PATCH = range(3)
# Orders of the harmonics relative to the first: bearing and gear parts of incommensurate pitch.
SECOND_ORDER, THIRD_ORDER = math.sqrt(3.0), math.sqrt(7.0)
FIRST_WEIGHT, SECOND_WEIGHT, THIRD_WEIGHT = 0.5, 0.3, 0.2
PATCH_SHARPNESS = 8.0  # of a von Mises density: half as high at 0.42 rad of the cycle from the centre of the patch
WIDE_RAD = 10.0  # a Gaussian window of this width covers the whole range


class PositionDependentFriction(HiddenEffect):
    summary = "the Coulomb level depends on the position"
    forms = ("sinusoid", "harmonics", "patch")

    share: float = strength(0.4, "largest change relative to the Coulomb level", lower=-1.0, upper=3.0)
    cycles_per_rev: float = number(3.0, "cycles per revolution of the joint", like="position_friction_order")
    phase_rad: float = number(0.5, "phase of the cycle at q = 0", "rad", lower=-inf)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        cosine, sine, order, centre, width = values.values()
        must(width >= WIDE_RAD, "its wave fills the whole range")
        must(setting.joint.coulomb_nm > 0.0, "its wave is a share of the Coulomb friction, which is none")
        share = math.hypot(cosine, sine) / setting.joint.coulomb_nm
        phase = math.remainder(math.atan2(cosine, sine) - order * centre, 2.0 * math.pi)
        return {"share": share, "cycles_per_rev": order, "phase_rad": phase, "form": "sinusoid"}


@compiled(inline=True)
def position_factor(group: Record, q: float) -> float:
    """Return the factor of the Coulomb friction at a position: 1 on average, never negative, so passive.

    Periodic after Armstrong-Helouvry, Control of Machines with Friction (1991), who found several spatial frequencies
    in one joint; the patch models a worn or dirty tooth.
    """
    angle, phase = group.cycles_per_rev * q, group.phase_rad
    if group.form == HARMONICS:
        first = FIRST_WEIGHT * math.sin(angle + phase)
        second = SECOND_WEIGHT * math.sin(SECOND_ORDER * angle + phase)
        change = first + second + THIRD_WEIGHT * math.sin(THIRD_ORDER * angle + phase)
    elif group.form == PATCH:
        change = math.exp(PATCH_SHARPNESS * (math.cos(angle + phase) - 1.0))
    else:
        change = math.sin(angle + phase)
    return float(max(0.0, 1.0 + group.share * change))


COGGING, READING = range(2)


class TorqueRipple(HiddenEffect):
    summary = "a torque, or an error of the torque sensor, that repeats with the turns of the motor"
    forms = ("cogging", "reading")

    torque_nm: float = strength(0.1, "amplitude of the first harmonic", "N m", lower=-inf)
    cycles_per_rev: float = number(200.0, "its cycles per revolution of the joint", like="ripple_order")
    second_share: float = number(0.3, "second harmonic relative to the first", lower=-inf)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        cosine, sine, order = values.values()
        size = math.hypot(cosine, sine)
        if abs(cosine) <= ALIKE * size:
            must(not setting.driven, "a motor that cogs beyond the sensor is not seen by it")
            return {"torque_nm": -sine, "cycles_per_rev": order, "second_share": 0.0, "form": "cogging"}
        must(abs(sine) <= ALIKE * size, "its ripple has the phase of a sine or of a cosine")
        return {"torque_nm": cosine, "cycles_per_rev": order, "second_share": 0.0, "form": "reading"}


@compiled()
def cogging_nm(group: Record, q: float) -> float:
    """Return the cogging torque on the motor, which is conservative; 0 with the form ``reading``. [N m]"""
    if group.form != COGGING or group.torque_nm == 0.0:
        return 0.0
    angle = group.cycles_per_rev * q
    return float(group.torque_nm * (math.sin(angle) + group.second_share * math.cos(2.0 * angle)))


def ripple_reading_nm(group: TorqueRipple, q: Float) -> Float:
    """Return the sensor ripple of a flexspline that is not round; 0 with the form ``cogging``. [N m]

    Two and four cycles per turn of the wave generator: Taghirad and Belanger, Intelligent built-in torque sensor for
    harmonic drive systems (1999).
    """
    if group.form != READING:
        return np.zeros_like(q)
    angle = group.cycles_per_rev * q
    return np.asarray(group.torque_nm * (np.cos(angle) + group.second_share * np.sin(2.0 * angle)))


class GravityError(HiddenEffect):
    """A wrong mass or centre of mass, an unknown payload or a tilted base: for one joint an amplitude and a phase."""

    summary = "the gravity torque that is subtracted is wrong"
    felt_at_rest = True

    torque_nm: float = strength(0.3, "amplitude", "N m", lower=-inf)
    phase_rad: float = number(0.0, "phase at q = 0", "rad", lower=-inf)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        cosine, sine = values["gravity_cos_nm"], values["gravity_sin_nm"]
        must(round(values["gravity_error_source"]) == 0, "it errs in the joint's own angle")
        size = math.hypot(cosine, sine)
        return {"torque_nm": -size if setting.driven else size, "phase_rad": math.atan2(cosine, sine)}


def gravity_error_nm(group: GravityError, q: Float) -> Float:
    """Return the error of the subtracted gravity torque, positive where it is too large, shape (n,). [N m]"""
    return np.asarray(group.torque_nm * np.sin(q + group.phase_rad))


LINEAR_CABLE, HARDENING_CABLE, SLACK, TETHER = range(4)
HARDENING_RAD = 1.0  # from the centre: there the hardening form is twice as strong as the linear one. [rad]


class CableSpring(HiddenEffect):
    summary = "a cable or hose pulls the joint back"
    forms = ("linear", "hardening", "slack", "tether")

    stiffness_nm_per_rad: float = strength(0.4, "stiffness where it pulls", "N m/rad", upper=2000.0)
    centre_rad: float = number(0.0, "position where it does not pull", like="cable_centre_rad")
    free_rad: float = number(0.3, "free play of a slack cable or a tether", like="cable_free_rad")

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        stiffness, hardening, preload, centre, free = values.values()
        must(abs(hardening) <= ALIKE * stiffness, "its cable that gets stiffer does so by a number of its own")
        must(preload == 0.0 or (free == 0.0 and stiffness > 0.0), "its cable hangs loose where it does not pull")
        if free > 0.0:
            place: Given = {"centre_rad": centre - setting.start_rad, "free_rad": free}
            return {"stiffness_nm_per_rad": stiffness, **place, "form": "slack"}
        middle = centre - (preload / stiffness if preload else 0.0) - setting.start_rad
        return {"stiffness_nm_per_rad": stiffness, "centre_rad": middle, "form": "linear"}


@compiled(inline=True)
def cable_spring_nm(group: Record, q: float) -> float:
    """Return the restoring torque of a cable; beyond its play a slack one acts on both sides, a tether on one. [N m]"""
    stretch = q - group.centre_rad
    if group.form == HARDENING_CABLE:
        stretch *= 1.0 + (stretch / HARDENING_RAD) ** 2
    elif group.form == SLACK:
        stretch -= min(max(stretch, -group.free_rad), group.free_rad)
    elif group.form == TETHER:
        stretch = max(0.0, stretch - group.free_rad)
    return float(-group.stiffness_nm_per_rad * stretch)


SPRING_DAMPER, QUADRATIC_WALL, EXPONENTIAL_WALL = range(3)
REFERENCE_RAD = 0.1  # depth at which the quadratic wall is as strong as the linear one. [rad]
WIDTH_RAD = 0.05  # distance over which the exponential wall grows by e. [rad]
HIGHEST_EXPONENT = 20.0  # no joint gets so deep into an exponential wall; the number stays finite


class JointLimitStop(HiddenEffect):
    summary = "a soft wall at both ends of the range"
    forms = ("spring_damper", "quadratic", "exponential")

    stiffness_nm_per_rad: float = strength(20.0, "stiffness of the walls", "N m/rad", upper=2000.0)
    at_rad: float = number(0.5, "where they stand, on both sides of the start pose", "rad")
    damping_s: float = number(0.02, "damping relative to the stiffness", "s", upper=0.2)


@compiled(inline=True)
def limit_stop_nm(group: Record, q: float, velocity: float) -> float:
    """Return the torque of both end stops, on the motor's side of the sensor. [N m]

    A stop never pulls and is passive. Spring and damper as in the virtual walls of haptics
    (Colgate and Brown 1994), quadratic with the damping of Hunt and Crossley (1975), exponential as a repulsive
    potential that acts before the stop.
    """
    torque, stiffness, damping = 0.0, group.stiffness_nm_per_rad, group.damping_s
    for side in (-1.0, 1.0):
        depth, inward, push = side * q - group.at_rad, side * velocity, 0.0
        if group.form == EXPONENTIAL_WALL:
            width = WIDTH_RAD * math.exp(min(depth / WIDTH_RAD, HIGHEST_EXPONENT))
            push = stiffness * width * max(0.0, 1.0 + inward * damping / WIDTH_RAD)
        elif depth > 0.0 and group.form == QUADRATIC_WALL:
            push = stiffness * (depth * depth / REFERENCE_RAD * max(0.0, 1.0 + inward * damping / REFERENCE_RAD))
        elif depth > 0.0:
            push = stiffness * max(0.0, depth + damping * inward)
        torque -= side * push
    return torque
