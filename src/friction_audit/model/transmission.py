"""Motion of the measured side -> torque through a transmission that twists or has play, friction on its far side.

The far side, inertia B with Coulomb and viscous friction, is drawn along by the measured side, and bears the load L
that gravity and the like put on the gear:

    B ddtheta + mu_c sgn(dtheta) + mu_v dtheta + L = T,    T = K e + D de/dt,    e = dead zone of (q - theta)

What is measured is T - L. A load twists the spring, and keeps the play closed where it is more than friction and
inertia.

M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987) 310, eq. (2);
M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002) 1633: the dead zone, and
flanks that never pull. Time is integrated by drift, kick and drift; Coulomb friction is implicit, so that it holds the
far side where it can (V. Acary, B. Brogliato, Numerical methods for nonsmooth dynamical systems, 2008).
"""

from dataclasses import dataclass, replace
from math import ceil, pi, sqrt

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.model.term import Motion

PHASE = 0.6
"""Most phase of the ringing per step of the integration: its frequency is right to phase^2 / 24, slower motion to far
less. [rad]"""
MOST_STEPS = 100
HIGHEST_HZ = 150.0
"""Ringing that is followed. Nobody looks above 40 Hz; there, what rings faster looks as if it rang so fast: behind a
spring with more inertia, behind flanks that give way more."""
MANY_SAMPLES = 4096
"""So many, spread evenly, tell inertia and friction."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FarSide:
    """What the transmission drives.

    Attributes:
        inertia_kg_m2: Inertia B. [kg m^2]
        coulomb_nm: Coulomb friction mu_c. [N m]
        viscous_nms_per_rad: Viscous friction mu_v. [N m s/rad]
    """

    inertia_kg_m2: float
    coulomb_nm: float
    viscous_nms_per_rad: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Transmission:
    """A spring, a damper and a play in a row.

    Attributes:
        stiffness_nm_per_rad: Stiffness K. [N m/rad]
        damping_ratio: Damping ratio of the far side on the spring.
        gap_rad: Full width of the play. [rad]
        soft_nm: Torque up to which the spring is half as stiff, as makers of strain-wave gears state it. [N m]
    """

    stiffness_nm_per_rad: float
    damping_ratio: float
    gap_rad: float = 0.0
    soft_nm: float = 0.0


def far_side(motion: Motion) -> FarSide:
    """Read inertia and friction off the torque of the simple model, which is linear in them.

    Numbers below zero, which a fit may give, count as zero: friction that pushes would run away.

    Raises:
        AnalysisError: If the motion says nothing of the simple model's torque.
    """
    every = max(len(motion.t) // MANY_SAMPLES, 1)
    dq, torque = motion.dq[::every], simple_torque(motion)[::every]
    columns = np.stack([motion.ddq[::every], np.sign(dq), dq])
    gram = np.linalg.pinv(columns @ columns.T, rcond=1e-12, hermitian=True)
    numbers = np.maximum(gram @ (columns @ torque), 0.0).tolist()
    return FarSide(inertia_kg_m2=numbers[0], coulomb_nm=numbers[1], viscous_nms_per_rad=numbers[2])


def simple_torque(motion: Motion) -> Float:
    """Return the torque of inertia, Coulomb and viscous friction.

    Raises:
        AnalysisError: If nobody has computed it.
    """
    if motion.rest is None:
        raise AnalysisError(
            "motion: no torque of inertia and friction (rest); a term that changes how it gets to the sensor needs it"
        )
    return motion.rest


def added_torque(motion: Motion, far: FarSide, transmission: Transmission) -> Float:
    """Return what a transmission adds to the torque of a rigid joint; nothing without an inertia. [N m], shape (n,)."""
    if far.inertia_kg_m2 == 0.0:
        return np.zeros(len(motion.t))
    far = slow_enough(far, transmission.stiffness_nm_per_rad)
    added = transmitted(motion, far, transmission)
    added -= far.inertia_kg_m2 * motion.ddq
    added -= far.coulomb_nm * motion.direction
    added -= far.viscous_nms_per_rad * motion.dq
    return added


def slow_enough(far: FarSide, stiffness_nm_per_rad: float) -> FarSide:
    """Return the far side, so heavy that its ringing can be followed."""
    return replace(far, inertia_kg_m2=max(far.inertia_kg_m2, stiffness_nm_per_rad / (2.0 * pi * HIGHEST_HZ) ** 2))


def transmitted(motion: Motion, far: FarSide, transmission: Transmission) -> Float:
    """Return the torque that the measured side feels, averaged from half a sample before to half a sample after.

    The load is not in it. The far side starts at the velocity of the measured side, twisted by the load alone.

    Args:
        motion: Evenly sampled.
        far: With an inertia above zero.
        transmission: With a stiffness above zero.
    """
    step = float(motion.t[1] - motion.t[0])
    rate = sqrt(transmission.stiffness_nm_per_rad / far.inertia_kg_m2)
    damping = 2.0 * transmission.damping_ratio * far.inertia_kg_m2 * rate
    steps = 2 * min(max(ceil(0.5 * step * rate / PHASE), 1), MOST_STEPS)
    return np.asarray(
        _follow(
            np.ascontiguousarray(motion.q, dtype=np.float64),
            np.ascontiguousarray(motion.dq, dtype=np.float64),
            np.zeros(len(motion.t)) if motion.load is None else np.ascontiguousarray(motion.load, dtype=np.float64),
            step,
            _between_samples(step, steps),
            (far.inertia_kg_m2, far.coulomb_nm, far.viscous_nms_per_rad),
            (transmission.stiffness_nm_per_rad, damping, 0.5 * transmission.gap_rad, transmission.soft_nm),
        )
    )


def _between_samples(step: float, steps: int) -> Float:
    """Weights of the rise and of both slopes in Hermite's cubic and its slope, amid every step, shape (steps, 6)."""
    x = (np.arange(steps) + 0.5) / steps
    rest = 1.0 - x
    place = (x**2 * (3.0 - 2.0 * x), step * x * rest**2, -step * x**2 * rest)
    speed = (6.0 * x * rest / step, rest * (1.0 - 3.0 * x), x * (3.0 * x - 2.0))
    return np.stack([*place, *speed], axis=1)


@compiled()
def _follow(
    q: Float,
    dq: Float,
    load: Float,
    step: float,
    between: Float,
    far: tuple[float, float, float],
    link: tuple[float, float, float, float],
) -> Float:
    """Integrate the far side; the measured side moves along the cubic through its samples and their slopes."""
    steps = len(between)
    h, damping = step / steps, link[1]
    touching, flying = _pace(far, damping, h), _pace(far, 0.0, h)
    torque = np.zeros(len(q))
    theta, omega = q[0] - _twist(load[0], link), dq[0]
    for k in range(len(q) - 1):
        rise, more = q[k + 1] - q[k], load[k + 1] - load[k]
        for i in range(steps):
            w = between[i]
            speed = w[3] * rise + w[4] * dq[k] + w[5] * dq[k + 1]
            theta += 0.5 * h * omega
            twist = q[k] + w[0] * rise + w[1] * dq[k] + w[2] * dq[k + 1] - theta
            push, drag = _push(twist, speed - omega, link)
            borne = load[k] + (i + 0.5) / steps * more
            # Damping at the mean of both velocities, then what Coulomb friction takes of the new one.
            keep, gain, held = touching if drag > 0.0 else flying
            before, free = omega, keep * omega + gain * (push + drag * speed - borne)
            omega = free - min(max(free, -held), held)
            theta += 0.5 * h * omega
            torque[k if 2 * i < steps else k + 1] += push + drag * (speed - 0.5 * (before + omega)) - borne
    torque /= steps
    torque[0] *= 2.0
    torque[-1] *= 2.0
    return torque


@compiled()
def _pace(far: tuple[float, float, float], drag: float, h: float) -> tuple[float, float, float]:
    """Return for a step what is left of a velocity, what a torque gives to it, and what Coulomb friction takes."""
    inertia, coulomb, viscous = far
    loss = 0.5 * h * (drag + viscous)
    gain = h / (inertia + loss)
    return (inertia - loss) / (inertia + loss), gain, gain * coulomb


@compiled()
def _twist(load: float, link: tuple[float, float, float, float]) -> float:
    """Return by how much a transmission is twisted at rest under a load; nothing without one. [rad]"""
    stiffness, _, half, soft = link
    if load == 0.0:
        return 0.0
    size = abs(load)
    twist = half + (size + min(size, soft)) / stiffness
    return twist if load > 0.0 else -twist


@compiled()
def _push(twist: float, closing: float, link: tuple[float, float, float, float]) -> tuple[float, float]:
    """Return the torque of the spring and the damping, both zero within the play and where flanks would pull."""
    stiffness, damping, half, soft = link
    if half == 0.0:
        straight = stiffness * twist
        return straight - min(max(0.5 * straight, -soft), soft), damping
    engaged = twist - min(max(twist, -half), half)
    straight = stiffness * engaged
    push = straight - min(max(0.5 * straight, -soft), soft)
    if engaged * (push + damping * closing) <= 0.0:
        return 0.0, 0.0
    return push, damping
