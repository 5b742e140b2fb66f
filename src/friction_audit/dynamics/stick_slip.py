"""A joint moved forward in time with stick and slip, compiled: of one mass, or of two with a spring or a gap between.

``Tables`` hold its torque over speed, position and time, and its bristles. The midpoint rule is of second order, stops
and break-aways included: where the velocity passes zero the joint stops inside the step, friction holds it until the
torque exceeds it, and that instant is found too.

    B_n ddq     = F + L - T
    B_f ddtheta = T - L - what the terms take,    T = K e + D de/dt,    e = dead zone of (q - theta)

Of two masses the far side moves as a joint of one does; the near side has inertia alone. ``F`` is the measured torque
and ``L`` the load on the gear, which is not in it. Drift, kick and drift, with the damper's torque at the mean of both
speeds: of second order, and stable for any damping.

M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987) 310, eq. (2);
M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002) 1633.
"""

from math import ceil, inf, sqrt
from typing import NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.bristles import bend_on, bristle_damping, bristle_nm
from friction_audit.dynamics.torque_tables import MOST_STEPS, SHARE_OF_SWING, Tables, steps_per_sample, taken
from friction_audit.dynamics.transmission import Transmission, amid, bend_of, between_samples, pushed, twisted
from friction_audit.joint_log import Float, Int

EVENTS = 8  # stops and break-aways that are resolved in one step


class Step(NamedTuple):
    """A step in time, under a torque that is linear in it."""

    h: float  # its length [s]
    drive0: float  # torque at its start [N m]
    drive1: float  # torque at its end [N m]
    begin: float  # its start, counted in samples of the recording that tables were made from
    end: float  # its end, likewise


@compiled(inline=True)
def rest_of(step: Step, share: float) -> Step:
    """Return what is left of a step after a share of it."""
    return Step(
        (1.0 - share) * step.h,
        step.drive0 + share * (step.drive1 - step.drive0),
        step.drive1,
        step.begin + share * (step.end - step.begin),
        step.end,
    )


@compiled(inline=True)
def slide(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> float:
    """Return the velocity of a joint with tables after sliding through a step in one direction."""
    bristles, damping = tables.bristles, bristle_damping(bent, sign, tables.bristles)
    torque = taken(sign, q, abs(v), step.begin, tables) + bristle_nm(bent, 0.0, bristles) + damping * v
    middle = v + 0.5 * step.h * (step.drive0 - torque) / tables.inertia_kg_m2
    speed, ahead = max(0.0, middle * sign), 0.5 * step.h * v
    sample, drive = 0.5 * (step.begin + step.end), 0.5 * (step.drive0 + step.drive1)
    torque = taken(sign, q + ahead, speed, sample, tables) + bristle_nm(bent, ahead, bristles) + damping * speed * sign
    return v + step.h * (drive - torque) / tables.inertia_kg_m2


@compiled()
def advance(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> tuple[float, float, float]:
    """Move a joint and its bristles on by a step; return position, velocity and direction, 0 where it is held."""
    for _ in range(EVENTS):
        if sign == 0.0:
            held = bristle_nm(bent, 0.0, tables.bristles)
            forwards, backwards = taken(1.0, q, 0.0, step.begin, tables), taken(-1.0, q, 0.0, step.begin, tables)
            if forwards < backwards:
                # Bristles bear all the friction: nothing dry is left that could hold the joint.
                forwards = backwards = 0.5 * (forwards + backwards)
            # The share of the step after which it moves, and the direction.
            start, end, share = step.drive0 - held, step.drive1 - held, 0.0
            if start > forwards or start < backwards:
                sign = 1.0 if start > forwards else -1.0
            elif end > forwards or end < backwards:
                sign, level = (1.0, forwards) if end > forwards else (-1.0, backwards)
                share = (level - start) / (end - start)
            else:
                return q, 0.0, 0.0
            step = rest_of(step, share)
        after = slide(q, v, sign, step, bent, tables)
        if after * sign >= 0.0:
            displacement = 0.5 * step.h * (v + after)
            bend_on(bent, displacement, tables.bristles)
            return q + displacement, after, sign
        share = v / (v - after)
        displacement = 0.5 * share * step.h * v
        bend_on(bent, displacement, tables.bristles)
        q, v, sign = q + displacement, 0.0, 0.0
        step = rest_of(step, share)
    return q, 0.0, 0.0


@compiled()
def run_pieces(
    step_s: float, steps: int, drive: Float, q: Float, dq: Float, pieces: Int, bent: Float, tables: Tables
) -> Float:
    """Move a joint with tables through pieces of a recording, each from the recorded start.

    Pieces are first and last sample, shape (p, 2); a sample of ``step_s`` takes ``steps`` steps. The drive is linear
    between samples. Drive, recorded position and velocity have the shape (n,), the bristles' state along the recording
    (n, 1 + m). Returns position and velocity, NaN outside of the pieces, shape (2, n).
    """
    out = np.full((2, len(drive)), np.nan)
    for p in range(len(pieces)):
        first, last = pieces[p]
        position, v, now = q[first], dq[first], bent[first].copy()
        sign = np.sign(v)
        out[0, first], out[1, first] = position, v
        for i in range(first, last):
            rise = (drive[i + 1] - drive[i]) / steps
            for k in range(steps):
                push = drive[i] + k * rise
                step = Step(step_s / steps, push, push + rise, i + k / steps, i + (k + 1.0) / steps)
                position, v, sign = advance(position, v, sign, step, now, tables)
            out[0, i + 1], out[1, i + 1] = position, v
    return out


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
    stiffness = transmission.stiffness_nm_per_rad
    damping = 2.0 * transmission.damping_ratio * sqrt(stiffness * far_kg_m2)
    return Link(near_kg_m2, stiffness, damping, 0.5 * transmission.gap_rad, *bend_of(transmission.soft_nm))


def ringing_steps(link: Link, far_kg_m2: float, step_s: float) -> int:
    """Return in how many steps of a sample the ringing of the two sides can be followed."""
    ringing = sqrt(link.stiffness_nm_per_rad * (1.0 / link.near_kg_m2 + 1.0 / far_kg_m2))
    return ceil(step_s * ringing / SHARE_OF_SWING)


def _between(link: Link, far: Tables, step_s: float) -> Float:
    steps = max(ringing_steps(link, far.inertia_kg_m2, step_s), steps_per_sample(step_s, far))
    return between_samples(step_s, min(steps, MOST_STEPS))


def follow(q: Float, dq: Float, load: Float, step_s: float, link: Link, far: Tables) -> Float:
    """Return both sides where the near one moves as recorded, as of endless inertia: columns as of ``_move``."""
    link = link._replace(near_kg_m2=inf)
    out = np.zeros((len(q), 5 + len(far.bristles.reach)))
    out[:, 0], out[:, 1] = q, dq
    out[0, 2] = q[0] - twisted(load[0], link.stiffness_nm_per_rad, link.half_rad, link.bend_nm)
    out[0, 3] = dq[0]
    _move(np.stack([load, load]), step_s, _between(link, far, step_s), (0, len(q) - 1), link, far, out)
    return out


def move_two_sides(
    drive: Float, load: Float, near: tuple[Float, Float], step_s: float, pieces: Int, link: Link, far: Tables
) -> Float:
    """Move a joint through pieces of a recording, each from the recorded start.

    Measured torque and load on the gear are linear between samples, shape (n,); ``near`` is the recorded position and
    velocity of the near side. The state of the far side at a start follows from the recorded motion before. Returns
    position and velocity of the near side, then of the far one, shape (4, n); outside of the pieces as recorded and as
    the far side follows that.
    """
    recorded = follow(*near, load, step_s, link, far)
    out, torques, between = recorded.copy(), np.stack([drive, load]), _between(link, far, step_s)
    for first, last in pieces.tolist():
        out[first] = recorded[first]
        _move(torques, step_s, between, (first, last), link, far, out)
    return out[:, :4].T


@compiled(inline=True)
def _transmit(twist: float, closing: float, loss: float, link: Link) -> float:
    """Return the torque for a twist that grows at a speed, of which damping takes a share in a step. [N m]"""
    engaged = twist - min(max(twist, -link.half_rad), link.half_rad)
    torque = pushed(link.stiffness_nm_per_rad * engaged, link.bend_nm, link.curve_per_nm)
    torque += link.damping_nms_per_rad * closing / (1.0 + loss)
    # Neither spring nor damper within the gap and where flanks would pull.
    return 0.0 if link.half_rad > 0.0 and engaged * torque <= 0.0 else torque


@compiled()
def _move(
    torques: Float, step_s: float, between: Float, piece: tuple[int, int], link: Link, far: Tables, out: Float
) -> None:
    """Move from the first sample of a piece to its last under drive and load, shape (2, n); changes ``out`` after it.

    Its columns: position and velocity of the near side, of the far side, bristles. A near side of endless inertia stays
    as it is there.
    """
    steps, first = len(between), piece[0]
    h = step_s / steps
    drive, load = torques
    q, v, theta, omega = out[first, 0], out[first, 1], out[first, 2], out[first, 3]
    bent, sign = out[first, 4:].copy(), np.sign(omega)
    loss = 0.5 * h * link.damping_nms_per_rad * (1.0 / far.inertia_kg_m2 + 1.0 / link.near_kg_m2)
    for i in range(first, piece[1]):
        for k in range(steps):
            at = (k + 0.5) / steps
            borne = load[i] + at * (load[i + 1] - load[i])
            position, speed = q + 0.5 * h * v, v
            if link.near_kg_m2 == inf:
                position, speed = amid(between[k], out[i, 0], out[i + 1, 0] - out[i, 0], out[i, 1], out[i + 1, 1])
            pull = _transmit(position - theta - 0.5 * h * omega, speed - omega, loss, link)
            step = Step(h, pull - borne, pull - borne, i + k / steps, i + (k + 1.0) / steps)
            theta, omega, sign = advance(theta, omega, sign, step, bent, far)
            after = v + h / link.near_kg_m2 * (drive[i] + at * (drive[i + 1] - drive[i]) + borne - pull)
            q, v = q + 0.5 * h * (v + after), after
        if link.near_kg_m2 < inf:
            out[i + 1, 0], out[i + 1, 1] = q, v
        out[i + 1, 2], out[i + 1, 3] = theta, omega
        for k in range(len(bent)):  # one by one: for a slice, numba compiles a message for seconds
            out[i + 1, 4 + k] = bent[k]
