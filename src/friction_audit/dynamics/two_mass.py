"""A joint of two masses, a spring or a gap between them, moved forward under a measured torque, compiled.

    B_n ddq     = F + L - T
    B_f ddtheta = T - L - what the terms take,    T = K e + D de/dt,    e = dead zone of (q - theta)

``F`` is the measured torque and ``L`` the load on the gear, which is not in it. The far side moves as a joint of one
mass does (``stick_slip``); the near side has inertia alone. Drift, kick and drift, with the damper's torque at the mean
of both speeds: of second order, and stable for any damping.

M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987) 310, eq. (2);
M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002) 1633.
"""

from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.dynamics.stick_slip import Step, advance
from friction_audit.dynamics.torque_tables import MOST_STEPS, SHARE_OF_SWING, Tables, steps_per_sample
from friction_audit.dynamics.transmission import Transmission, amid, bend_of, between_samples, pushed, twisted
from friction_audit.joint_log import Float


class Link(NamedTuple):
    """What is between the two sides."""

    near_kg_m2: float  # inertia B_n of the measured side [kg m^2]
    stiffness_nm_per_rad: float  # stiffness K [N m/rad]
    damping_nms_per_rad: float  # damping D [N m s/rad]
    half_rad: float  # half of the width of the gap [rad]
    bend_nm: float  # torque b of ``transmission``, up to which the spring stiffens [N m]
    curve_per_nm: float  # 1 / (4 b), 0 for a straight spring [1/(N m)]


def link_of(transmission: Transmission, near_kg_m2: float, far_kg_m2: float) -> Link:
    """Return what a transmission is between two inertias; its damping ratio is that of the far one."""
    stiffness, (bend_nm, curve_per_nm) = transmission.stiffness_nm_per_rad, bend_of(transmission.soft_nm)
    damping = 2.0 * transmission.damping_ratio * sqrt(stiffness * far_kg_m2)
    return Link(near_kg_m2, stiffness, damping, 0.5 * transmission.gap_rad, bend_nm, curve_per_nm)


def can_follow(link: Link, whole: Tables, step_s: float) -> bool:
    """Whether the near side has inertia enough for its ringing to be followed; ``whole`` has that of both sides."""
    far_kg_m2 = whole.inertia_kg_m2 - link.near_kg_m2
    return link.near_kg_m2 > 0.0 and far_kg_m2 > 0.0 and _ringing_steps(link, far_kg_m2, step_s) <= MOST_STEPS


def _ringing_steps(link: Link, far_kg_m2: float, step_s: float) -> int:
    ringing = sqrt(link.stiffness_nm_per_rad * (1.0 / link.near_kg_m2 + 1.0 / far_kg_m2))
    return ceil(step_s * ringing / SHARE_OF_SWING)


def follow(q: Float, dq: Float, load: Float, step_s: float, link: Link, far: Tables) -> Float:
    """Return position, velocity and bristles of a far side whose near side moves as recorded, shape (n, 3 + m).

    Of the near side: position [rad] and velocity [rad/s]; load on the gear [N m]; what the far side takes, with its
    inertia.
    """
    ringing = ceil(step_s * sqrt(link.stiffness_nm_per_rad / far.inertia_kg_m2) / SHARE_OF_SWING)
    between = between_samples(step_s, min(max(ringing, steps_per_sample(step_s, far)), MOST_STEPS))
    q, dq, load = (np.ascontiguousarray(one) for one in (q, dq, load))
    return np.asarray(_follow(q, dq, load, step_s, between, link, far))


def move_two_sides(
    drive: Float,
    load: Float,
    near: tuple[Float, Float],
    step_s: float,
    pieces: NDArray[np.int64],
    link: Link,
    far: Tables,
) -> Float:
    """Move a joint through pieces of a recording, each from the recorded start.

    Measured torque and load on the gear are linear between samples, shape (n,); ``near`` is the recorded position and
    velocity of the near side. The state of the far side at a start follows from the recorded motion before.

    Returns:
        Position and velocity of the near side, then of the far one, shape (4, n); outside of the pieces as recorded and
        as the far side follows that.
    """
    ringing = _ringing_steps(link, far.inertia_kg_m2, step_s)
    steps = min(max(ringing, steps_per_sample(step_s, far)), MOST_STEPS)
    states = follow(*near, load, step_s, link, far)
    out = np.stack([*near, states[:, 0], states[:, 1]])
    for first, last in pieces:
        piece = (int(first), int(last))
        _release(np.stack([drive, load]), step_s, steps, piece, states[first], link, far, out)
    return out


@compiled(inline=True)
def _transmit(twist: float, closing: float, loss: float, link: Link) -> float:
    """Return the torque for a twist that grows at a speed, of which damping takes a share in a step. [N m]"""
    engaged = twist - min(max(twist, -link.half_rad), link.half_rad)
    torque = pushed(link.stiffness_nm_per_rad * engaged, link.bend_nm, link.curve_per_nm)
    torque += link.damping_nms_per_rad * closing / (1.0 + loss)
    # Neither spring nor damper within the gap and where flanks would pull.
    return 0.0 if link.half_rad > 0.0 and engaged * torque <= 0.0 else torque


@compiled()
def _follow(q: Float, dq: Float, load: Float, step_s: float, between: Float, link: Link, far: Tables) -> Float:
    """Position, velocity and bristles of a far side whose near side moves as recorded, shape (n, 3 + m)."""
    steps = len(between)
    h = step_s / steps
    bent = np.zeros(1 + len(far.bristles.reach))
    out = np.zeros((len(q), 2 + len(bent)))
    theta, omega = q[0] - twisted(load[0], link.stiffness_nm_per_rad, link.half_rad, link.bend_nm), dq[0]
    sign = np.sign(omega)
    loss = 0.5 * h * link.damping_nms_per_rad / far.inertia_kg_m2
    for i in range(len(q)):
        out[i, 0], out[i, 1] = theta, omega
        for k in range(len(bent)):  # one by one: for a slice, numba compiles a message for seconds
            out[i, 2 + k] = bent[k]
        if i + 1 == len(q):
            break
        for k in range(steps):
            at = (k + 0.5) / steps
            place, speed = amid(between[k], q[i], q[i + 1] - q[i], dq[i], dq[i + 1])
            pull = _transmit(place - theta - 0.5 * h * omega, speed - omega, loss, link)
            pull -= load[i] + at * (load[i + 1] - load[i])
            step = Step(h, pull, pull, i + k / steps, i + (k + 1.0) / steps)
            theta, omega, sign = advance(theta, omega, sign, step, bent, far)
    return out


@compiled()
def _release(
    torques: Float, step_s: float, steps: int, piece: tuple[int, int], state: Float, link: Link, far: Tables, out: Float
) -> None:
    """Let both sides go from the first sample of a piece to its last; changes ``out`` after the first."""
    h = step_s / steps
    drive, load = torques
    q, v, theta, omega, bent = out[0, piece[0]], out[1, piece[0]], state[0], state[1], state[2:].copy()
    sign = np.sign(omega)
    loss = 0.5 * h * link.damping_nms_per_rad * (1.0 / far.inertia_kg_m2 + 1.0 / link.near_kg_m2)
    for i in range(piece[0], piece[1]):
        for k in range(steps):
            at = (k + 0.5) / steps
            borne = load[i] + at * (load[i + 1] - load[i])
            pull = _transmit(q - theta + 0.5 * h * (v - omega), v - omega, loss, link)
            after = v + h / link.near_kg_m2 * (drive[i] + at * (drive[i + 1] - drive[i]) + borne - pull)
            step = Step(h, pull - borne, pull - borne, i + k / steps, i + (k + 1.0) / steps)
            theta, omega, sign = advance(theta, omega, sign, step, bent, far)
            q, v = q + 0.5 * h * (v + after), after
        out[0, i + 1], out[1, i + 1], out[2, i + 1], out[3, i + 1] = q, v, theta, omega
