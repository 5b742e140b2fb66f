"""Motion of the measured side -> torque through a transmission that twists or has play, friction on its far side.

The far side, inertia B with Coulomb and viscous friction, is drawn along by the measured side:

    B ddtheta + mu_c sgn(dtheta) + mu_v dtheta = T,    T = K e + D de/dt,    e = dead zone of (q - theta)

M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987) 310, eq. (2);
M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002) 1633: the dead zone, and
flanks that never pull. Time is integrated by drift, kick and drift; Coulomb friction is implicit, so that it holds the
far side where it can (V. Acary, B. Brogliato, Numerical methods for nonsmooth dynamical systems, 2008).
"""

from dataclasses import dataclass, replace
from math import ceil, sqrt

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.model.term import Motion

PHASE = 0.2
"""Phase of the ringing per step of the integration: its frequency is right to a few thousandths. [rad]"""
MOST_STEPS = 100
MOST_PHASE = 1.0
"""And twice that would run away. [rad]"""


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
    columns = np.stack([motion.ddq, np.sign(motion.dq), motion.dq])
    gram = np.linalg.pinv(columns @ columns.T, rcond=1e-12, hermitian=True)
    numbers = np.maximum(gram @ (columns @ simple_torque(motion)), 0.0).tolist()
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
    far = _slow_enough(far, transmission.stiffness_nm_per_rad, float(motion.t[1] - motion.t[0]))
    friction = far.coulomb_nm * np.sign(motion.dq) + far.viscous_nms_per_rad * motion.dq
    return transmitted(motion, far, transmission) - far.inertia_kg_m2 * motion.ddq - friction


def _slow_enough(far: FarSide, stiffness_nm_per_rad: float, step_s: float) -> FarSide:
    """The far side, so heavy that its ringing can be followed: kilohertz, where nobody sees a difference."""
    least = stiffness_nm_per_rad * (step_s / (2 * MOST_STEPS * MOST_PHASE)) ** 2
    return replace(far, inertia_kg_m2=max(far.inertia_kg_m2, least))


def transmitted(motion: Motion, far: FarSide, transmission: Transmission) -> Float:
    """Return the torque that the measured side feels, averaged from half a sample before to half a sample after.

    The far side starts without a twist at the velocity of the measured side.

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
            step,
            steps,
            (far.inertia_kg_m2, far.coulomb_nm, far.viscous_nms_per_rad),
            (transmission.stiffness_nm_per_rad, damping, 0.5 * transmission.gap_rad, transmission.soft_nm),
        )
    )


@compiled()
def _follow(
    q: Float,
    dq: Float,
    step: float,
    steps: int,
    far: tuple[float, float, float],
    link: tuple[float, float, float, float],
) -> Float:
    """Integrate the far side; the measured side moves along the cubic through its samples and their slopes."""
    inertia, coulomb, viscous = far
    h = step / steps
    torque = np.zeros(len(q))
    share = np.full(len(q), 1.0 * steps)
    share[0] = share[-1] = 0.5 * steps
    theta, omega = q[0], dq[0]
    for k in range(len(q) - 1):
        for i in range(steps):
            x = (i + 0.5) / steps
            # Hermite's cubic and its slope at the middle of the step.
            rise = q[k + 1] - q[k]
            bend0, bend1 = step * dq[k] - rise, rise - step * dq[k + 1]
            place = q[k] + x * (rise + (1.0 - x) * ((1.0 - x) * bend0 + x * bend1))
            speed = (rise + (1.0 - x) * (1.0 - 3.0 * x) * bend0 + x * (2.0 - 3.0 * x) * bend1) / step
            theta += 0.5 * h * omega
            push, drag = _push(place - theta, speed - omega, link)
            # Damping at the mean of both velocities, then what Coulomb friction takes of the new one.
            loss, before = 0.5 * h * (drag + viscous), omega
            free = ((inertia - loss) * omega + h * (push + drag * speed)) / (inertia + loss)
            held = h * coulomb / (inertia + loss)
            omega = max(free - held, 0.0) if free > 0.0 else min(free + held, 0.0)
            theta += 0.5 * h * omega
            near = k if 2 * i < steps else k + 1
            torque[near] += (push + drag * (speed - 0.5 * (before + omega))) / share[near]
    return torque


@compiled()
def _push(twist: float, closing: float, link: tuple[float, float, float, float]) -> tuple[float, float]:
    """Return the torque of the spring and the damping, both zero within the play and where flanks would pull."""
    stiffness, damping, half, soft = link
    engaged = max(abs(twist) - half, 0.0)
    sign = 1.0 if twist > 0.0 else -1.0
    push = sign * max(stiffness * engaged - soft, 0.5 * stiffness * engaged)
    if half > 0.0 and (engaged == 0.0 or (push + damping * closing) * sign < 0.0):
        return 0.0, 0.0
    return push, damping
