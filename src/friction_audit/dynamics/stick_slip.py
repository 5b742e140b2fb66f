"""Forward integration of a joint with stick-slip, compiled: of one mass, or of two with a spring or backlash between.

``Tables`` hold the resisting torque over speed, position and time, and the bristles. The midpoint rule is of second
order, also through stick-slip transitions: the step is split where the velocity passes zero and where the torque
exceeds the breakaway torque.

    B_m ddq     = F + L - T
    B_f ddtheta = T - L - resisting torque,    T = K e + D de/dt,    e = dead zone of (q - theta)

In the two-mass model the friction side theta moves as the joint of one mass does; the measured side q has inertia only.
``F`` is the measured torque, ``L`` the load on the gear, which ``F`` does not contain. The scheme is leapfrog (drift,
kick, drift) with the damper's torque at the mean of both velocities: of second order, and stable for any damping.

M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987) 310, eq. (2);
M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002) 1633.
"""

from math import ceil, inf, sqrt
from typing import NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics import transmission
from friction_audit.dynamics.bristles import advance_bristles, bristle_damping, bristle_nm
from friction_audit.dynamics.torque_tables import MOST_STEPS, STEP_PHASE_RAD, Tables, lookup_nm, steps_per_sample
from friction_audit.joint_log import Float, Int

EVENTS = 8  # stick-slip transitions that are resolved in one step


class Step(NamedTuple):
    """A time step under a torque that is linear in time."""

    h: float  # length [s]
    drive0: float  # torque at the start [N m]
    drive1: float  # torque at the end [N m]
    begin: float  # start, in samples of the recording that the tables were made from
    end: float  # end, in such samples


@compiled(inline=True)
def remaining(step: Step, share: float) -> Step:
    """Return the rest of a step after a share of it."""
    return Step(
        (1.0 - share) * step.h,
        step.drive0 + share * (step.drive1 - step.drive0),
        step.drive1,
        step.begin + share * (step.end - step.begin),
        step.end,
    )


@compiled(inline=True)
def slide(q: float, v: float, sign: float, step: Step, state: Float, tables: Tables) -> float:
    """Return the velocity after a step of sliding in one direction, by the midpoint rule. [rad/s]"""
    bristles, damping = tables.bristles, bristle_damping(state, sign, tables.bristles)
    torque = lookup_nm(sign, q, abs(v), step.begin, tables) + bristle_nm(state, 0.0, bristles) + damping * v
    middle = v + 0.5 * step.h * (step.drive0 - torque) / tables.inertia_kg_m2
    speed, ahead = max(0.0, middle * sign), 0.5 * step.h * v
    sample, drive = 0.5 * (step.begin + step.end), 0.5 * (step.drive0 + step.drive1)
    torque = lookup_nm(sign, q + ahead, speed, sample, tables) + bristle_nm(state, ahead, bristles)
    return v + step.h * (drive - (torque + damping * speed * sign)) / tables.inertia_kg_m2


@compiled()
def advance(q: float, v: float, sign: float, step: Step, state: Float, tables: Tables) -> tuple[float, float, float]:
    """Integrate a joint and its bristles over a step; return position, velocity and direction, 0 if it sticks."""
    for _ in range(EVENTS):
        if sign == 0.0:
            elastic = bristle_nm(state, 0.0, tables.bristles)
            forwards = lookup_nm(1.0, q, 0.0, step.begin, tables)
            backwards = lookup_nm(-1.0, q, 0.0, step.begin, tables)
            if forwards < backwards:
                # All friction is in the bristles: no static friction is left.
                forwards = backwards = 0.5 * (forwards + backwards)
            # Direction of the breakaway, and the share of the step before it.
            start, end, share = step.drive0 - elastic, step.drive1 - elastic, 0.0
            if start > forwards or start < backwards:
                sign = 1.0 if start > forwards else -1.0
            elif end > forwards or end < backwards:
                sign, level = (1.0, forwards) if end > forwards else (-1.0, backwards)
                share = (level - start) / (end - start)
            else:
                return q, 0.0, 0.0
            step = remaining(step, share)
        after = slide(q, v, sign, step, state, tables)
        if after * sign >= 0.0:
            displacement = 0.5 * step.h * (v + after)
            advance_bristles(state, displacement, tables.bristles)
            return q + displacement, after, sign
        share = v / (v - after)
        displacement = 0.5 * share * step.h * v
        advance_bristles(state, displacement, tables.bristles)
        q, v, sign = q + displacement, 0.0, 0.0
        step = remaining(step, share)
    return q, 0.0, 0.0


@compiled()
def integrate_segments(
    step_s: float, steps: int, drive: Float, q: Float, dq: Float, segments: Int, states: Float, tables: Tables
) -> Float:
    """Integrate a joint with tables over segments of a recording, each from its recorded start.

    Segments are first and last sample, shape (p, 2); a sample of ``step_s`` has ``steps`` steps. The drive is linear
    between samples. Drive, recorded position and velocity have the shape (n,), the bristles' states along the recording
    (n, 1 + m). Returns position and velocity, NaN outside of the segments, shape (2, n).
    """
    out = np.full((2, len(drive)), np.nan)
    for p in range(len(segments)):
        first, last = segments[p]
        position, v, state = q[first], dq[first], states[first].copy()
        sign = np.sign(v)
        out[0, first], out[1, first] = position, v
        for i in range(first, last):
            rise = (drive[i + 1] - drive[i]) / steps
            for k in range(steps):
                torque = drive[i] + k * rise
                step = Step(step_s / steps, torque, torque + rise, i + k / steps, i + (k + 1.0) / steps)
                position, v, sign = advance(position, v, sign, step, state, tables)
            out[0, i + 1], out[1, i + 1] = position, v
    return out


class TwoMass(NamedTuple):
    """Parameters of the two-mass model, without the friction side: tables hold its inertia and friction."""

    inertia_kg_m2: float  # inertia B_m of the measured side, infinite where its motion is given [kg m^2]
    stiffness_nm_per_rad: float  # stiffness K [N m/rad]
    damping_nms_per_rad: float  # damping D [N m s/rad]
    half_gap_rad: float  # half of the width of the backlash [rad]
    knee_nm: float  # torque b of ``transmission``, up to which the spring hardens [N m]
    curvature_per_nm: float  # 1 / (4 b), 0 for a linear spring [1/(N m)]


def two_mass_model(gear: transmission.Transmission, measured_kg_m2: float, friction_kg_m2: float) -> TwoMass:
    """Return the model of a gear between two inertias; its damping ratio is that of the friction side."""
    stiffness = gear.stiffness_nm_per_rad
    damping = 2.0 * gear.damping_ratio * sqrt(stiffness * friction_kg_m2)
    return TwoMass(measured_kg_m2, stiffness, damping, 0.5 * gear.gap_rad, *transmission.hardening(gear.soft_nm))


def resonance_steps(model: TwoMass, friction_kg_m2: float, step_s: float) -> int:
    """Return the steps per sample that the resonance of the two masses takes."""
    frequency = sqrt(model.stiffness_nm_per_rad * (1.0 / model.inertia_kg_m2 + 1.0 / friction_kg_m2))
    return ceil(step_s * frequency / STEP_PHASE_RAD)


def _weights(model: TwoMass, tables: Tables, step_s: float) -> Float:
    steps = max(resonance_steps(model, tables.inertia_kg_m2, step_s), steps_per_sample(step_s, tables))
    return transmission.hermite_weights(step_s, min(steps, MOST_STEPS))


def integrate_friction_side(q: Float, dq: Float, load: Float, step_s: float, model: TwoMass, tables: Tables) -> Float:
    """Integrate the friction side along the recorded motion of the measured side; columns as of ``_integrate``."""
    model = model._replace(inertia_kg_m2=inf)
    out = np.zeros((len(q), 5 + len(tables.bristles.stiffness)))
    out[:, 0], out[:, 1] = q, dq
    out[0, 2] = q[0] - transmission.static_twist(load[0], model.stiffness_nm_per_rad, model.half_gap_rad, model.knee_nm)
    out[0, 3] = dq[0]
    _integrate(np.stack([load, load]), step_s, _weights(model, tables, step_s), (0, len(q) - 1), model, tables, out)
    return out


def integrate_two_masses(
    torques: Float, measured: tuple[Float, Float], step_s: float, segments: Int, model: TwoMass, tables: Tables
) -> Float:
    """Integrate both sides over segments of a recording, each from its recorded start.

    Measured torque and load on the gear are linear between samples, shape (2, n); ``measured`` is the recorded position
    and velocity of the measured side. The friction side at a start follows from the recorded motion before. Returns
    position and velocity of the measured side, then of the friction side, shape (4, n); recorded between segments.
    """
    recorded = integrate_friction_side(*measured, torques[1], step_s, model, tables)
    out, weights = recorded.copy(), _weights(model, tables, step_s)
    for first, last in segments.tolist():
        out[first] = recorded[first]
        _integrate(torques, step_s, weights, (first, last), model, tables, out)
    return out[:, :4].T


@compiled(inline=True)
def _transmitted(twist: float, rate: float, loss: float, model: TwoMass) -> float:
    """Return the torque for a twist and its rate; ``loss`` is the share of the rate that damping takes. [N m]"""
    engaged = twist - min(max(twist, -model.half_gap_rad), model.half_gap_rad)
    torque = transmission.spring_torque(model.stiffness_nm_per_rad * engaged, model.knee_nm, model.curvature_per_nm)
    torque += model.damping_nms_per_rad * rate / (1.0 + loss)
    # Neither spring nor damper acts within the gap or where the contact would pull.
    return 0.0 if model.half_gap_rad > 0.0 and engaged * torque <= 0.0 else torque


@compiled()
def _integrate(
    torques: Float, step_s: float, weights: Float, segment: tuple[int, int], model: TwoMass, tables: Tables, out: Float
) -> None:
    """Integrate from the first to the last sample of a segment under drive and load, shape (2, n); fills ``out``.

    Columns of ``out``: position and velocity of the measured side, of the friction side, state of the bristles. With
    infinite inertia, the measured side stays as it is there.
    """
    steps, first = len(weights), segment[0]
    h = step_s / steps
    drive, load = torques
    q, v, theta, omega = out[first, 0], out[first, 1], out[first, 2], out[first, 3]
    state, sign = out[first, 4:].copy(), np.sign(omega)
    loss = 0.5 * h * model.damping_nms_per_rad * (1.0 / tables.inertia_kg_m2 + 1.0 / model.inertia_kg_m2)
    for i in range(first, segment[1]):
        rise = out[i + 1, 0] - out[i, 0]
        for k in range(steps):
            at = (k + 0.5) / steps
            borne = load[i] + at * (load[i + 1] - load[i])
            position, speed = q + 0.5 * h * v, v
            if model.inertia_kg_m2 == inf:
                position, speed = transmission.hermite(weights[k], out[i, 0], rise, out[i, 1], out[i + 1, 1])
            torque = _transmitted(position - theta - 0.5 * h * omega, speed - omega, loss, model)
            step = Step(h, torque - borne, torque - borne, i + k / steps, i + (k + 1.0) / steps)
            theta, omega, sign = advance(theta, omega, sign, step, state, tables)
            after = v + h / model.inertia_kg_m2 * (drive[i] + at * (drive[i + 1] - drive[i]) + borne - torque)
            q, v = q + 0.5 * h * (v + after), after
        if model.inertia_kg_m2 < inf:
            out[i + 1, 0], out[i + 1, 1] = q, v
        out[i + 1, 2], out[i + 1, 3] = theta, omega
        for k in range(len(state)):  # one by one: for a slice, numba compiles a message for seconds
            out[i + 1, 4 + k] = state[k]
