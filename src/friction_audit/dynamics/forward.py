"""A joint of any terms moved forward under a recorded torque, piece by piece, each from its recorded start.

Torques that follow from the instant are tabulated, bristles follow their curve (``torque_tables``). A term that needs
the past of the motion gives its torque along the motion found so far, and the motion is found again until it no longer
changes; a term with which it never settles cannot be simulated.

A transmission between the torque sensor and the side on which friction acts does not change that side's motion under a
measured torque, unless part of the inertia is before it; it changes what is measured. A delay of the torque is undone
in the drive. Where part of the inertia is on the measured side of a spring or a gap, both sides are moved
(``stick_slip``). Where none is, a spring puts the measured side ahead by torque times compliance, a little late by its
damping. Within a gap the torque is then zero and does not determine the measured side: that is taken from the
recording, and the other side follows it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import sqrt
from typing import NamedTuple

import numpy as np

from friction_audit.dynamics.motion import Forward, Model, Motion, Term
from friction_audit.dynamics.stick_slip import Link, follow, link_of, move_two_sides, ringing_steps, run_pieces
from friction_audit.dynamics.torque_tables import MOST_STEPS, Tables, certain, rms, steps_per_sample, tabulate
from friction_audit.dynamics.transmission import HIGHEST_HZ, Transmission, flank_stiffness, straightened
from friction_audit.joint_log import Float, Int
from friction_audit.preprocessing.even_grid import first_order

SWEEPS = 12
SETTLED = 1e-3  # rms change of the velocity in a sweep at which it has settled, as a share of the rms velocity
RUNAWAY = 100.0  # a velocity of this multiple of the largest recorded one is no result
# Standard deviation of the bell under which the torque that twists a spring is averaged, in radians of the far side's
# ringing: of that 96 % pass. The rate of the twist multiplies noise of the torque by its frequency.
SMOOTH_RAD = 0.3
LEAST_INERTIA = 1e-3  # share of the joint's inertia that terms must leave
BETWEEN = ("delay", "spring", "gap")  # what is between the sensor and the side of friction


class _Recording(NamedTuple):
    """A recording of the measured side, n samples."""

    motion: Motion
    drive: Float  # torque at its time [N m]
    load: Float  # load on the gear that is not in it [N m]
    pieces: Int  # first and last sample of each piece, shape (p, 2)
    step_s: float


def simulate_along(model: Model, motion: Motion, drive: Float, pieces: Int, load: Float | None = None) -> Float | None:
    """Simulate a joint under a torque F_m + u as recorded, along a recording on an even grid.

    Pieces are their first and last sample, shape (p, 2); the load is what is on the gear and not in the drive, that of
    the motion where None. Returns the velocity on the measured side, shape (n,) [rad/s]: NaN outside of the pieces;
    None where it does not settle or grows beyond all bounds.
    """
    between = {term.effect.forward: term for term in model.terms if term.effect.forward in BETWEEN}
    if (late := between.get("delay")) is not None:
        # The torque at its time; of a load that is late too, what was taken away too early is given back.
        own = np.zeros(len(drive)) if motion.load is None else motion.load * round(_parameter(late, "delayed_load"))
        drive = np.asarray(np.interp(motion.t + _parameter(late, "delay_s"), motion.t, drive + own) - own)
    load = motion.load if load is None else load
    load = np.zeros(len(drive)) if load is None else load
    recording = _Recording(motion, drive, load, pieces, float(motion.t[1] - motion.t[0]))
    acting = [term for term in model.terms if term.effect.forward not in BETWEEN]
    tables, past = tabulate(model.inertia_kg_m2, acting, replace(motion, rest=model.rest(motion)))
    if tables.inertia_kg_m2 <= LEAST_INERTIA * abs(model.inertia_kg_m2):
        return None
    transmission, link = _transmission(model, motion, between), None
    if transmission is not None:
        near = (1.0 - transmission.far_share) * model.inertia_kg_m2
        far = tables.inertia_kg_m2 - near
        link = link_of(transmission, near, far)
        # The near side needs inertia enough for its ringing to be followed.
        if min(near, far) > 0.0 and ringing_steps(link, far, recording.step_s) <= MOST_STEPS:
            return _settle(model, tables, past, recording, partial(_both_sides, recording, link))
    move = partial(_one_side, recording, _ahead(recording, link, tables))
    return _settle(model, tables, past, recording, move)


def _settle(
    model: Model,
    tables: Tables,
    past: Sequence[Term],
    recording: _Recording,
    move: Callable[[Tables], tuple[Float, Float, Float]],
) -> Float | None:
    """Sweep until motion and torque of terms with a past fit each other; return the velocity of the measured side.

    ``move`` returns position and velocity of the side of friction, and velocity of the measured side.
    """
    recorded, inside = recording.motion, np.zeros(len(recording.drive), bool)
    for first, stop in recording.pieces:
        inside[first : stop + 1] = True
    motion, last = recorded, recorded.dq
    for _ in range(SWEEPS):
        known, time = replace(motion, rest=model.rest(motion)), tables.time
        for term in past:
            time = time + _by_direction(term.torque(known), certain(motion), motion.t)
        q, dq, measured_dq = move(tables._replace(time=time))
        if not (np.abs(dq[inside]) <= RUNAWAY * np.max(np.abs(recorded.dq))).all():
            return None
        if not past or rms(dq[inside] - last[inside]) <= SETTLED * rms(recorded.dq[inside]):
            return np.where(inside, measured_dq, np.nan)
        ddq = recorded.ddq.copy()
        for first, stop in recording.pieces:
            ddq[first : stop + 1] = np.gradient(dq[first : stop + 1], recording.step_s)
        own_q, own_dq = np.where(inside, q, recorded.q), np.where(inside, dq, recorded.dq)
        motion, last = replace(recorded, q=own_q, dq=own_dq, ddq=ddq), dq
    return None


def _both_sides(recording: _Recording, link: Link, tables: Tables) -> tuple[Float, Float, Float]:
    motion, drive, load, pieces, step_s = recording
    far = tables._replace(inertia_kg_m2=tables.inertia_kg_m2 - link.near_kg_m2)
    _, speed, theta, omega = move_two_sides(drive, load, (motion.q, motion.dq), step_s, pieces, link, far)
    return theta, omega, speed


def _one_side(recording: _Recording, ahead: Float, tables: Tables) -> tuple[Float, Float, Float]:
    """Move the side of friction; the measured one is ahead by a given angle, shape (n,)."""
    step_s, rate = recording.step_s, np.gradient(ahead, recording.step_s)
    q, dq = recording.motion.q - ahead, recording.motion.dq - rate
    bent, steps = tables.bristles.states_along(q), steps_per_sample(step_s, tables)
    position, speed = run_pieces(step_s, steps, recording.drive, q, dq, recording.pieces, bent, tables)
    return position, speed, speed + rate


def _by_direction(torque: Float, direction: Float, t: Float) -> Float:
    """Torque forwards and backwards, shape (2, n): against the motion or independent of it, what jumps less.

    Friction jumps where the direction turns; its level against the motion does not. It is interpolated where no
    direction is certain.
    """
    sure = direction != 0.0
    if not sure.any():
        return np.stack([torque, torque])
    level = np.interp(t, t[sure], (torque * direction)[sure])
    turns = np.abs(np.diff(torque[sure])).sum() > np.abs(np.diff((torque * direction)[sure])).sum()
    return np.stack([level, -level] if turns else [torque, torque])


def _transmission(model: Model, motion: Motion, between: Mapping[Forward, Term]) -> Transmission | None:
    """The spring, the gap, or both in a row, the spring in the place of the flanks; None without either."""
    spring, backlash = between.get("spring"), between.get("gap")
    share = min(_parameter(term, "far_share", 1.0) for term in (spring, backlash))
    gap_rad, compliance = _parameter(backlash, "_rad"), _parameter(spring, "_rad_per_nm")
    if compliance > 0.0:
        stiffness, damping_ratio = 1.0 / compliance, _parameter(spring, "damping_ratio")
        soft_nm = _parameter(spring, "soft_nm")
    elif backlash is not None:
        contact_hz = _parameter(backlash, "_hz", HIGHEST_HZ)
        stiffness = flank_stiffness(share * model.inertia_kg_m2, contact_hz, gap_rad, rms(model.rest(motion)))
        damping_ratio, soft_nm = _parameter(backlash, "damping_ratio", 1.0), 0.0
    else:
        return None
    return Transmission(
        stiffness_nm_per_rad=stiffness, damping_ratio=damping_ratio, gap_rad=gap_rad, soft_nm=soft_nm, far_share=share
    )


def _ahead(recording: _Recording, link: Link | None, far: Tables) -> Float:
    """By how far the measured side, without inertia, is ahead; of a gap what its dead zone takes, (n,). [rad]"""
    motion, drive, step_s = recording.motion, recording.drive, recording.step_s
    if link is None:
        return np.zeros(len(drive))
    if link.half_rad > 0.0:
        theta = follow(motion.q, motion.dq, recording.load, step_s, link, far)[:, 2]
        return np.clip(motion.q - theta, -link.half_rad, link.half_rad)
    from scipy.ndimage import gaussian_filter1d

    width = SMOOTH_RAD / sqrt(link.stiffness_nm_per_rad / far.inertia_kg_m2)
    torque = np.asarray(gaussian_filter1d(drive + recording.load, width / step_s, mode="nearest"))
    twist = np.array([straightened(one, link.bend_nm) for one in torque]) / link.stiffness_nm_per_rad
    time_s = link.damping_nms_per_rad / link.stiffness_nm_per_rad
    if time_s <= 0.0:
        return twist
    # A first-order lag, exact for a twist that is linear between samples.
    keep = np.exp(-step_s / time_s)
    bend = 1.0 - (1.0 - keep) * time_s / step_s
    driven = (bend * twist + (1.0 - keep - bend) * np.append(twist[0], twist[:-1])) / (1.0 - keep)
    return np.asarray(first_order(driven, float(keep), twist[0]))


def _parameter(term: Term | None, ending: str, default: float = 0.0) -> float:
    """Return the parameter of a term whose name has an ending, or the default where there is none."""
    pairs = () if term is None else zip(term.effect.parameters, term.values, strict=True)
    return next((value for parameter, value in pairs if parameter.name.endswith(ending)), default)
