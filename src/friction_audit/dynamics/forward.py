"""Forward simulation of a joint with any terms under a recorded torque, in segments, each from its recorded start.

Memoryless terms are lookup tables, presliding terms are bristles (``torque_tables``). A term with memory is evaluated
along the simulated motion, which is simulated again until it converges.

A transmission between the torque sensor and the friction side changes the measured motion, not the motion of the
friction side under the measured torque, unless part of the inertia is on the measured side. A delay of the torque is
undone in the drive. Where part of the inertia is on the measured side of a spring or a gap, both sides are integrated
(``stick_slip``). Where none is, a spring twists by torque times compliance, with a first-order lag by its damping.
Within a gap the torque is zero and does not determine the measured side: it is taken from the recording, and the
friction side follows it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import sqrt
from typing import NamedTuple

import numpy as np

from friction_audit.dynamics import stick_slip
from friction_audit.dynamics.motion import Forward, Model, Motion, Term
from friction_audit.dynamics.torque_tables import MOST_STEPS, Tables, certain_direction, rms, steps_per_sample, tabulate
from friction_audit.dynamics.transmission import HIGHEST_HZ, Transmission, contact_stiffness, linear_torque
from friction_audit.joint_log import Float, Int
from friction_audit.preprocessing.even_grid import first_order

ITERATIONS = 12
CONVERGED = 1e-3  # rms change of the velocity in an iteration that counts as convergence, as a share of its rms
DIVERGED = 100.0  # a velocity above this multiple of the largest recorded one has diverged
# Standard deviation of the Gaussian low-pass of the torque that twists a spring, as phase of the friction side's
# resonance, of which 96 % pass [rad]. The rate of the twist amplifies noise of the torque with its frequency.
SMOOTH_RAD = 0.3
LEAST_INERTIA = 1e-3  # smallest share of the joint's inertia that terms must leave
BETWEEN = ("delay", "spring", "gap")  # effects between the sensor and the friction side


class _Recording(NamedTuple):
    """A recording of the measured side, n samples."""

    motion: Motion
    drive: Float  # torque, delay undone [N m]
    load: Float  # load on the gear that the drive does not contain [N m]
    segments: Int  # first and last sample of each segment, shape (p, 2)
    step_s: float


def simulate_segments(
    model: Model, motion: Motion, drive: Float, segments: Int, load: Float | None = None
) -> Float | None:
    """Simulate a joint under the recorded torque F_m + u, in segments of an evenly sampled recording.

    Segments are first and last sample, shape (p, 2); the load on the gear, which the drive does not contain, is that of
    the motion where None. Returns the velocity of the measured side, shape (n,) [rad/s], NaN outside of the segments;
    None where it does not converge or diverges.
    """
    between = {term.effect.forward: term for term in model.terms if term.effect.forward in BETWEEN}
    if (late := between.get("delay")) is not None:
        # Undo the delay of the torque; a load that is delayed too was subtracted too early.
        own = np.zeros(len(drive)) if motion.load is None else motion.load * round(_parameter(late, "delayed_load"))
        drive = np.asarray(np.interp(motion.t + _parameter(late, "delay_s"), motion.t, drive + own) - own)
    load = next((one for one in (load, motion.load) if one is not None), np.zeros(len(drive)))
    step_s = float(motion.t[1] - motion.t[0])
    recording = _Recording(motion, drive, load, segments, step_s)
    acting = [term for term in model.terms if term.effect.forward not in BETWEEN]
    tables, with_memory = tabulate(model.inertia_kg_m2, acting, replace(motion, rest=model.rest(motion)))
    if tables.inertia_kg_m2 <= LEAST_INERTIA * abs(model.inertia_kg_m2):
        return None
    transmission, two_mass = _transmission(model, motion, between), None
    if transmission is not None:
        measured = (1.0 - transmission.far_share) * model.inertia_kg_m2
        friction = tables.inertia_kg_m2 - measured
        two_mass = stick_slip.two_mass_model(transmission, measured, friction)
        # Two masses need enough inertia on both sides for the resonance to be integrated.
        if min(measured, friction) > 0.0 and stick_slip.resonance_steps(two_mass, friction, step_s) <= MOST_STEPS:
            return _iterate(model, tables, with_memory, recording, partial(_two_masses, recording, two_mass))
    integrate = partial(_one_mass, recording, _twist(recording, two_mass, tables))
    return _iterate(model, tables, with_memory, recording, integrate)


def _iterate(
    model: Model,
    tables: Tables,
    with_memory: Sequence[Term],
    recording: _Recording,
    integrate: Callable[[Tables], tuple[Float, Float, Float]],
) -> Float | None:
    """Iterate until the motion and the torque of terms with memory agree; return the velocity of the measured side.

    ``integrate`` returns position and velocity of the friction side, and velocity of the measured side.
    """
    recorded, inside = recording.motion, np.zeros(len(recording.drive), bool)
    for first, last in recording.segments:
        inside[first : last + 1] = True
    motion, previous = recorded, recorded.dq
    for _ in range(ITERATIONS):
        known, time = replace(motion, rest=model.rest(motion)), tables.time
        for term in with_memory:
            time = time + _by_direction(term.torque(known), certain_direction(motion), motion.t)
        q, dq, measured_dq = integrate(tables._replace(time=time))
        if not (np.abs(dq[inside]) <= DIVERGED * np.max(np.abs(recorded.dq))).all():
            return None
        if not with_memory or rms(dq[inside] - previous[inside]) <= CONVERGED * rms(recorded.dq[inside]):
            return np.where(inside, measured_dq, np.nan)
        ddq = recorded.ddq.copy()
        for first, last in recording.segments:
            ddq[first : last + 1] = np.gradient(dq[first : last + 1], recording.step_s)
        own_q, own_dq = np.where(inside, q, recorded.q), np.where(inside, dq, recorded.dq)
        motion, previous = replace(recorded, q=own_q, dq=own_dq, ddq=ddq), dq
    return None


def _two_masses(recording: _Recording, model: stick_slip.TwoMass, tables: Tables) -> tuple[Float, Float, Float]:
    motion, drive, load, segments, step_s = recording
    torques, measured = np.stack([drive, load]), (motion.q, motion.dq)
    tables = tables._replace(inertia_kg_m2=tables.inertia_kg_m2 - model.inertia_kg_m2)
    _, dq, theta, omega = stick_slip.integrate_two_masses(torques, measured, step_s, segments, model, tables)
    return theta, omega, dq


def _one_mass(recording: _Recording, twist: Float, tables: Tables) -> tuple[Float, Float, Float]:
    """Integrate the friction side; the measured side is ahead by the twist, shape (n,)."""
    motion, drive, _, segments, step_s = recording
    rate, steps = np.gradient(twist, step_s), steps_per_sample(step_s, tables)
    q, dq = motion.q - twist, motion.dq - rate
    states = tables.bristles.states_along(q)
    q, dq = stick_slip.integrate_segments(step_s, steps, drive, q, dq, segments, states, tables)
    return q, dq, dq + rate


def _by_direction(torque: Float, direction: Float, t: Float) -> Float:
    """Return the torque forwards and backwards, shape (2, n), as friction or as independent of the direction.

    The one with the smaller total variation is taken: friction jumps where the direction turns, its level does not. The
    level is interpolated where the direction is uncertain.
    """
    sure = direction != 0.0
    if not sure.any():
        return np.stack([torque, torque])
    level = np.interp(t, t[sure], (torque * direction)[sure])
    turns = np.abs(np.diff(torque[sure])).sum() > np.abs(np.diff((torque * direction)[sure])).sum()
    return np.stack([level, -level] if turns else [torque, torque])


def _transmission(model: Model, motion: Motion, between: Mapping[Forward, Term]) -> Transmission | None:
    """Return the spring, the backlash, or both in series, the spring as the contact; None without either."""
    spring, backlash = between.get("spring"), between.get("gap")
    share = min(_parameter(term, "far_share", 1.0) for term in (spring, backlash))
    gap_rad, compliance = _parameter(backlash, "_rad"), _parameter(spring, "_rad_per_nm")
    if compliance > 0.0:
        stiffness, damping_ratio = 1.0 / compliance, _parameter(spring, "damping_ratio")
        soft_nm = _parameter(spring, "soft_nm")
    elif backlash is not None:
        contact_hz = _parameter(backlash, "_hz", HIGHEST_HZ)
        stiffness = contact_stiffness(share * model.inertia_kg_m2, contact_hz, gap_rad, rms(model.rest(motion)))
        damping_ratio, soft_nm = _parameter(backlash, "damping_ratio", 1.0), 0.0
    else:
        return None
    return Transmission(
        stiffness_nm_per_rad=stiffness, damping_ratio=damping_ratio, gap_rad=gap_rad, soft_nm=soft_nm, far_share=share
    )


def _twist(recording: _Recording, model: stick_slip.TwoMass | None, tables: Tables) -> Float:
    """Return the angle by which the measured side, without inertia, is ahead of the friction side, shape (n,). [rad]"""
    motion, drive, step_s = recording.motion, recording.drive, recording.step_s
    if model is None:
        return np.zeros(len(drive))
    if model.half_gap_rad > 0.0:
        theta = stick_slip.integrate_friction_side(motion.q, motion.dq, recording.load, step_s, model, tables)[:, 2]
        return np.clip(motion.q - theta, -model.half_gap_rad, model.half_gap_rad)
    from scipy.ndimage import gaussian_filter1d

    width = SMOOTH_RAD / sqrt(model.stiffness_nm_per_rad / tables.inertia_kg_m2)
    torque = np.asarray(gaussian_filter1d(drive + recording.load, width / step_s, mode="nearest"))
    twist = np.array([linear_torque(one, model.knee_nm) for one in torque]) / model.stiffness_nm_per_rad
    time_s = model.damping_nms_per_rad / model.stiffness_nm_per_rad
    if time_s <= 0.0:
        return twist
    # A first-order lag, exact for a twist that is linear between samples.
    keep = np.exp(-step_s / time_s)
    new = 1.0 - (1.0 - keep) * time_s / step_s
    driven = (new * twist + (1.0 - keep - new) * np.append(twist[0], twist[:-1])) / (1.0 - keep)
    return np.asarray(first_order(driven, float(keep), twist[0]))


def _parameter(term: Term | None, ending: str, default: float = 0.0) -> float:
    """Return the parameter of a term whose name has an ending, or the default where there is none."""
    pairs = () if term is None else zip(term.effect.parameters, term.values, strict=True)
    return next((value for parameter, value in pairs if parameter.name.endswith(ending)), default)
