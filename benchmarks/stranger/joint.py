"""One joint as a state-space model, integrated with a fixed step.

The measured side (position theta, inertia ``motor_share * inertia``) drives the link (position q) through a spring
with a dead zone; without a spring both are one. The link rubs: LuGre bristles (Canudas de Wit et al. 1995) whose level
may follow speed, position, load, direction, time and rest, and springs in parallel that slip (Iwan 1966). The damping
of the bristles fades with the speed: a constant one would peak at every reversal as high as friction itself.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

STEP_S = 1e-4
SLIPPING = 6
"""Number of the Maxwell-slip springs, whose yields are spread evenly up to the reach."""


class Joint(NamedTuple):
    """What the joint is made of: SI units; what is zero is not there."""

    inertia: float = 0.3
    coulomb: float = 0.3
    viscous: float = 0.06
    bristle_rad: float = 1e-6
    bristle_speed: float = 5e-4
    stribeck: float = 0.0
    stribeck_speed: float = 0.1
    stribeck_exponent: float = 2.0
    curved: float = 0.0
    curved_exponent: float = 2.0
    saturating: float = 0.0
    saturation_speed: float = 0.5
    uneven_coulomb: float = 0.0
    uneven_viscous: float = 0.0
    soft: float = 0.0
    soft_reach_rad: float = 5e-3
    ageing: float = 0.0
    ageing_s: float = 0.3
    renewal_rad: float = 0.01
    worn: float = 0.0
    worn_centre_rad: float = 0.0
    worn_width_rad: float = 0.2
    eccentric: float = 0.0
    eccentric_order: float = 1.0
    pendulum: float = 0.0
    payload_factor: float = 1.0
    payload_s: float = 1e9
    load_share: float = 0.0
    heavier_sin: float = 0.0
    heavier_cos: float = 0.0
    hose: float = 0.0
    hose_hardening: float = 0.0
    hose_centre_rad: float = 0.0
    hose_slack_rad: float = 0.0
    stop: float = 0.0
    stop_rad: float = 10.0
    ripple: float = 0.0
    ripple_second: float = 0.0
    ripple_order: float = 40.0
    ripple_phase: float = 0.0
    cold: float = 0.0
    cold_viscous: float = 0.0
    warming_s: float = 60.0
    stepped: float = 0.0
    step_s: float = 1e9
    maxwell: float = 0.0
    maxwell_s: float = 2.0
    slosh: float = 0.0
    slosh_hz: float = 3.0
    slosh_damping: float = 0.05
    pushed: float = 0.0
    push_s: float = 1e9
    push_long_s: float = 0.3
    spring_hz: float = 0.0
    spring_damping: float = 0.1
    motor_share: float = 0.2
    gap_rad: float = 0.0


class Drive(NamedTuple):
    """Who moves the measured side: a spring and a damper to a moving point, and the torque known beforehand."""

    stiffness: float
    damping: float
    ahead: float
    through: float = 1.0
    """1 where the gear transmits weight and drive, -1 where a hand beyond the sensor takes from the weight."""


@njit(cache=True)
def known_load(joint: Joint, q: float, t: float) -> float:
    """Weight of the link, which is known, and heavier by a payload from a moment on. [N m]"""
    factor = joint.payload_factor if t > joint.payload_s else 1.0
    return float(joint.pendulum * factor * np.sin(q + 0.4))


@njit(cache=True)
def friction_level(joint: Joint, q: float, v: float, t: float, rested: float, transmitted: float) -> float:
    """What the bristles carry in steady sliding. [N m]"""
    level = joint.coulomb + joint.stribeck * np.exp(-((abs(v) / joint.stribeck_speed) ** joint.stribeck_exponent))
    level += joint.uneven_coulomb * np.sign(v)
    level += joint.worn * np.exp(-0.5 * ((q - joint.worn_centre_rad) / joint.worn_width_rad) ** 2)
    level += joint.eccentric * np.cos(joint.eccentric_order * q + 1.0)
    level += joint.load_share * abs(transmitted)
    level += joint.cold * np.exp(-t / joint.warming_s) + joint.ageing * np.log1p(rested / joint.ageing_s)
    level += joint.stepped if t > joint.step_s else 0.0
    return float(max(level, 0.02))


@njit(cache=True)
def viscous_torque(joint: Joint, v: float, t: float) -> float:
    """Torque that follows from the speed at once. [N m]"""
    factor = joint.viscous + joint.uneven_viscous * np.sign(v) + joint.cold_viscous * np.exp(-t / joint.warming_s)
    curved = joint.curved * np.sign(v) * abs(v) ** joint.curved_exponent
    return float(factor * v + curved + joint.saturating * np.tanh(v / joint.saturation_speed))


@njit(cache=True)
def resting_torque(joint: Joint, q: float, t: float) -> float:
    """Torque that follows from the position and the time alone, whichever way the joint goes. [N m]"""
    off = q - joint.hose_centre_rad
    stretch = np.sign(off) * max(abs(off) - joint.hose_slack_rad, 0.0)
    torque = joint.hose * stretch + joint.hose_hardening * stretch**3
    torque += joint.heavier_sin * np.sin(q) + joint.heavier_cos * np.cos(q)
    torque += joint.ripple * np.cos(joint.ripple_order * q + joint.ripple_phase)
    torque += joint.ripple_second * np.cos(2 * joint.ripple_order * q)
    torque += joint.stop * max(q - joint.stop_rad, 0.0) / 0.1
    since = t - joint.push_s
    if 0.0 < since < joint.push_long_s:
        torque += joint.pushed * np.sin(np.pi * since / joint.push_long_s)
    return float(torque)


@njit(cache=True)
def through_gap(angle: float, gap: float) -> float:
    """What of an angle is beyond a play of this whole width. [rad]"""
    return float(np.sign(angle) * max(abs(angle) - 0.5 * gap, 0.0))


@njit(cache=True)
def integrate(
    joint: Joint, drive: Drive, wanted: NDArray[np.float64], grip: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Position and speed of the measured side, torque of the drive, torque in the spring; all of the shape of wanted.

    ``wanted`` [rad] is where the drive would be, ``grip`` how firmly it holds, from 0 to 1; both in steps of STEP_S.
    """
    n = wanted.size
    theta, omega, driven, sprung = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    x, w = wanted[0], 0.0
    q, v = x, 0.0
    bristle, rested, hose, load, load_speed = 0.0, 0.0, 0.0, 0.0, 0.0
    soft = np.zeros(SLIPPING)
    rigid = joint.spring_hz == 0.0
    motor = joint.inertia * joint.motor_share
    spring = (2 * np.pi * joint.spring_hz) ** 2 * joint.inertia
    damper = 2 * joint.spring_damping * np.sqrt(spring * motor * joint.inertia / (motor + joint.inertia))
    stiff = joint.coulomb / joint.bristle_rad
    bristle_damping = np.sqrt(stiff * joint.inertia)
    slosh_rate = 2 * np.pi * joint.slosh_hz
    for i in range(n):
        t = i * STEP_S
        middle = min(max(i, 1), n - 2)
        before, after = wanted[middle - 1], wanted[middle + 1]
        speed, acceleration = (after - before) / (2 * STEP_S), (after - 2 * wanted[middle] + before) / STEP_S**2
        torque = grip[i] * (
            drive.stiffness * (wanted[i] - x) + drive.damping * (speed - w) + drive.ahead * joint.inertia * acceleration
        )
        twist = through_gap(x - q, joint.gap_rad)
        link = torque if rigid else spring * twist + (damper * (w - v) if twist != 0.0 else 0.0)

        transmitted = known_load(joint, q, t) + drive.through * link
        level = friction_level(joint, q, v, t, rested, transmitted)
        new = (bristle + STEP_S * v) / (1.0 + STEP_S * stiff * abs(v) / level)
        calm = np.exp(-((v / joint.bristle_speed) ** 2))
        rub = stiff * new + calm * bristle_damping * (new - bristle) / STEP_S + viscous_torque(joint, v, t)
        bristle = new
        for k in range(SLIPPING):
            reach = joint.soft_reach_rad * (k + 1) / SLIPPING
            soft[k] = min(max(soft[k] + STEP_S * v, -reach), reach)
            rub += joint.soft * soft[k] / reach / SLIPPING
        rested += STEP_S * (1.0 - abs(v) * rested / joint.renewal_rad)
        hose += STEP_S * (v - hose / joint.maxwell_s)
        load_pull = joint.slosh * (slosh_rate**2 * (load - q) + 2 * joint.slosh_damping * slosh_rate * (load_speed - v))
        if joint.slosh > 0.0:
            load_speed -= STEP_S * load_pull / joint.slosh
            load += STEP_S * load_speed

        push = link - rub - resting_torque(joint, q, t) - joint.maxwell * hose + load_pull
        theta[i], omega[i], driven[i], sprung[i] = x, w, torque, link
        v += STEP_S * push / joint.inertia
        q += STEP_S * v
        if rigid:
            x, w = q, v
        else:
            w += STEP_S * (torque - link) / motor
            x += STEP_S * w
    return theta, omega, driven, sprung
