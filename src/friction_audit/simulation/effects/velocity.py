"""Friction over velocity: Stribeck curve, stiction, viscous friction, asymmetry, presliding and frictional lag."""

import math

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength

EXPONENTIAL, LORENTZIAN, PIECEWISE = range(3)


class Stribeck(HiddenEffect):
    summary = "friction falls from rest to the Coulomb level as the speed rises"
    forms = ("exponential", "lorentzian", "piecewise")
    same_law = "exponential"

    excess_nm: float = strength(0.15, "friction at rest above the Coulomb level", like="stribeck_excess_nm")
    speed_rad_s: float = number(0.1, "speed over which it falls", like="stribeck_speed_rad_s")
    exponent: float = number(2.0, "exponent of the exponential form", like="stribeck_exponent")


@compiled(inline=True)
def stribeck_nm(group: Record, speed: float) -> float:
    """Return the Stribeck friction above the Coulomb friction at a speed (not negative). [N m]"""
    ratio = speed / group.speed_rad_s
    if group.form == LORENTZIAN:
        return float(group.excess_nm / (1.0 + ratio * ratio))
    if group.form == PIECEWISE:
        return float(group.excess_nm * max(0.0, 1.0 - ratio))
    return float(group.excess_nm * math.exp(-(ratio**group.exponent)))


SATURATING, LOGARITHMIC, IMMEDIATE = range(3)
LONG_REST_S = 10.0


class Stiction(HiddenEffect):
    summary = "break-away takes more than slow sliding, the more the longer the rest"
    forms = ("saturating", "logarithmic", "immediate")

    excess_nm: float = strength(
        0.2, "break-away above sliding after a long rest (logarithmic: 10 s)", like="breakaway_excess_nm"
    )
    dwell_s: float = number(0.5, "rest over which it grows", like="ageing_s")


@compiled(inline=True)
def stiction_nm(group: Record, rest_s: float) -> float:
    """Return the static friction above the kinetic friction after a dwell time (not negative). [N m]

    Saturating is Kato, Sato and Matsubayashi (1972) with exponent 1; logarithmic is the ageing of contacts (Rabinowicz
    1958, Dieterich 1972), unbounded: ten times the dwell time adds a fixed amount; immediate is the static friction of
    Karnopp (1985), which does not depend on the dwell time.
    """
    if group.form == LOGARITHMIC:
        share = math.log1p(rest_s / group.dwell_s) / math.log1p(LONG_REST_S / group.dwell_s)
        return float(group.excess_nm * share)
    if group.form == IMMEDIATE:
        return float(group.excess_nm)
    return float(-group.excess_nm * math.expm1(-rest_s / group.dwell_s))


POWER, EYRING, ARCTAN, CUBIC = range(4)
BEND = 10.0  # reference speed over that of the knee, eyring and arctan forms
SMALL_SPEED_RAD_S = 0.02  # viscous friction with a knee at a lower speed is a power of the speed


class NonlinearViscous(HiddenEffect):
    summary = "friction grows with speed along a curve, not a line"
    forms = ("power", "eyring", "arctan", "cubic")

    torque_nm: float = strength(0.15, "extra friction at the reference speed", "N m")
    exponent: float = number(2.0, "exponent of the power form", lower=0.2, upper=4.0)
    speed_rad_s: float = number(1.0, "reference speed", "rad/s", lower=0.001)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        torque, exponent, bend = list(values.values())[:3]
        must(bend <= SMALL_SPEED_RAD_S, f"its friction that bends at {bend:g} rad/s is no power of the speed")
        return {"torque_nm": torque, "exponent": exponent, "speed_rad_s": 1.0, "form": "power"}


@compiled(inline=True)
def nonlinear_viscous_nm(group: Record, speed: float) -> float:
    """Return the friction in addition to linear viscous friction at a speed (not negative, monotonic). [N m]

    Power is Waiboer, Aarts and Jonker (2005); eyring is the shear thinning of a lubricant (Eyring 1936); arctan
    saturates; both have their knee at a tenth of the reference speed; cubic is the odd polynomial of Simoni et al.
    (2015).
    """
    ratio = speed / group.speed_rad_s
    if group.form == EYRING:
        return float(group.torque_nm * math.asinh(BEND * ratio) / math.asinh(BEND))
    if group.form == ARCTAN:
        return float(group.torque_nm * math.atan(BEND * ratio) / math.atan(BEND))
    if group.form == CUBIC:
        return float(group.torque_nm * ratio * ratio * ratio)
    return float(group.torque_nm * ratio**group.exponent)


class AsymmetricCoulomb(HiddenEffect):
    """Passive up to the joint's Coulomb friction, as asymmetric viscous friction is up to its viscous coefficient."""

    summary = "Coulomb friction differs between the directions"
    same_law = ""

    half_difference_nm: float = strength(
        0.08, "half of Coulomb friction forward less backward", like="coulomb_half_difference_nm"
    )


class AsymmetricViscous(HiddenEffect):
    summary = "viscous friction differs between the directions"
    same_law = ""

    half_difference_nms_per_rad: float = strength(
        0.03, "half of the viscous coefficient forward less backward", like="viscous_half_difference_nms_per_rad"
    )


LUGRE, DAHL, MAXWELL_SLIP = range(3)
BRISTLES = 8
# Maxwell-slip elements carry equal shares of the friction and yield at evenly spaced deflections (Iwan 1966), the first
# such that their stiffnesses add up to that at rest.
FIRST_YIELD = sum(1.0 / k for k in range(1, BRISTLES + 1)) / BRISTLES
LINEAR = 1e-9
LEAST_LEVEL = 1e-6


class Presliding(HiddenEffect):
    summary = "friction builds up like a spring over the path since a reversal"
    forms = ("lugre", "dahl", "maxwell_slip")

    displacement_rad: float = strength(0.005, "Coulomb friction over the stiffness at rest", "rad", upper=0.1)
    damping_s: float = number(0.005, "micro-damping over stiffness, LuGre form", "s", upper=0.1)
    exponent: float = number(1.5, "exponent of the Dahl form", lower=0.2, upper=3.0)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        bristles, reach, exponent, damping = values.values()
        all_of_it = abs(bristles - setting.joint.coulomb_nm) <= 2 * ALIKE * bristles
        must(all_of_it, "its bristles bear all of the Coulomb friction, no other share of it")
        if exponent == 1.0:
            return {"displacement_rad": reach, "damping_s": damping, "form": "lugre"}
        must(damping == 0.0, "its bristles with damping have the exponent 1")
        return {"displacement_rad": reach, "exponent": exponent, "form": "dahl"}


@compiled(inline=True)
def dahl_advance(z: float, sigma0: float, level: float, velocity: float, h: float, exponent: float) -> float:
    """Return the deflection after a step h at constant velocity, by the exact solution of Dahl (1976). [rad]"""
    if velocity == 0.0:
        return z
    sign = 1.0 if velocity > 0.0 else -1.0
    path = sigma0 * abs(velocity) * h / level
    missing = 1.0 - sigma0 * z * sign / level
    bend = exponent - 1.0
    if abs(bend) < LINEAR or missing == 0.0:
        missing *= math.exp(-path)
    else:
        grown = 1.0 + bend * path * abs(missing) ** bend
        missing *= grown ** (-1.0 / bend) if grown > 0.0 else 0.0
    return sign * level * (1.0 - missing) / sigma0


@compiled(inline=True)
def presliding_advance(
    group: Record, bristles: Float, coulomb_nm: float, level: float, velocity: float, h: float
) -> None:
    """Advance the deflections of the bristles by a step h at constant velocity, in place.

    LuGre and Dahl use the first deflection. Coulomb friction, above zero, determines the stiffness. The level is the
    friction of steady sliding without its viscous part, at least a millionth of Coulomb friction.
    """
    level = max(level, LEAST_LEVEL * coulomb_nm)
    sigma0 = coulomb_nm / group.displacement_rad
    if group.form == LUGRE:
        # The exact solution of Canudas de Wit et al. (1995), eq. 1, stable for every h.
        decay = sigma0 * abs(velocity) * h / level
        reached = -math.expm1(-decay) / decay if decay > 0.0 else 1.0
        bristles[0] = bristles[0] * math.exp(-decay) + velocity * h * reached
    elif group.form == DAHL:
        bristles[0] = dahl_advance(bristles[0], sigma0, level, velocity, h, group.exponent)
    else:
        for k in range(BRISTLES):
            limit = group.displacement_rad * FIRST_YIELD * (k + 1) * level / coulomb_nm
            held = min(limit, max(-limit, bristles[k]))
            bristles[k] = min(limit, max(-limit, held + velocity * h))


@compiled(inline=True)
def presliding_force_nm(group: Record, bristles: Float, coulomb_nm: float, level: float, velocity: float) -> float:
    """Return the friction torque without its viscous part; in steady forward motion it is the level. [N m]

    Passive in every form, also for a varying level: the stored energy is sigma0 z^2 / 2, summed over the elements.
    Under a load that oscillates below break-away, LuGre and Dahl creep (Dupont et al. 2002); Maxwell-slip does not.
    """
    level = max(level, LEAST_LEVEL * coulomb_nm)
    sigma0 = coulomb_nm / group.displacement_rad
    if group.form == LUGRE:
        # The micro-damping falls with speed, so that LuGre is passive at every viscous coefficient: with the stored
        # energy sigma0 z^2 / 2 this takes sigma1 |v| <= 4 level (Barabanov and Ortega 2000).
        sigma1 = group.damping_s * sigma0
        sigma1 = sigma1 / (1.0 + sigma1 * abs(velocity) / (4.0 * level))
        rate = velocity - sigma0 * abs(velocity) * bristles[0] / level
        return float(sigma0 * bristles[0] + sigma1 * rate)
    if group.form == DAHL:
        return float(sigma0 * bristles[0])
    force = 0.0
    for k in range(BRISTLES):
        force += coulomb_nm / (BRISTLES * (group.displacement_rad * FIRST_YIELD * (k + 1))) * bristles[k]
    return force


RELAXING, DELAYED = range(2)
LONGEST_LAG_S = 0.05
SAMPLE_S = 0.0005
SLOTS = 104  # of the longest lag, and room to interpolate
AGE, NEWEST, PREVIOUS, RING = range(4)
LAG_MEMORY = RING + SLOTS


class FrictionalLag(HiddenEffect):
    summary = "friction answers late to a change of speed"
    forms = ("relaxing", "delayed")

    lag_s: float = strength(0.03, "time by which friction lags the speed", "s", upper=LONGEST_LAG_S)


@compiled(inline=True)
def frictional_lag_speed(group: Record, memory: Float, speed: float, h: float) -> float:
    """Advance by a step h to the present speed and return the lagged speed, on which friction depends. [rad/s]

    Relaxing is the first-order state of rate-and-state friction (Ruina 1983), delayed the pure time lag of Hess and
    Soom (1990). Passive: the direction is that of the present motion.
    The memory, shape (LAG_MEMORY,), is zero at rest and changed in place.
    """
    if group.lag_s == 0.0:
        return speed
    if group.form == RELAXING:
        memory[PREVIOUS] -= (speed - memory[PREVIOUS]) * math.expm1(-h / group.lag_s)
        return float(memory[PREVIOUS])
    # A sample of the speed every 0.5 ms, for any steps; between two calls the speed is linear in time.
    memory[AGE] += h
    while memory[AGE] >= SAMPLE_S:
        memory[AGE] -= SAMPLE_S
        memory[NEWEST] = (int(memory[NEWEST]) + 1) % SLOTS
        memory[RING + int(memory[NEWEST])] = speed - (speed - memory[PREVIOUS]) * memory[AGE] / h
    memory[PREVIOUS] = speed
    # The speed of a lag ago, linear between the samples.
    newest, since = int(memory[NEWEST]), group.lag_s - memory[AGE]
    if since <= 0.0:
        return float(speed + (memory[RING + newest] - speed) * group.lag_s / memory[AGE])
    slot = int(since / SAMPLE_S)
    later, earlier = memory[RING + (newest - slot) % SLOTS], memory[RING + (newest - slot - 1) % SLOTS]
    return float(later + (earlier - later) * (since / SAMPLE_S - slot))
