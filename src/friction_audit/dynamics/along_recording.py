"""A joint of any terms moved forward under a recorded torque, piece by piece, each from its recorded start.

Torques that follow from the instant are tabulated, bristles follow their curve (``tables``). A term that needs the
past of the motion is asked for its torque along the motion found so far, and the motion is found again, until it no
longer changes; a term with which it never settles cannot be simulated.

What sits between the torque sensor and the side on which friction acts does not change that side's motion under a
measured torque, unless part of the inertia is before it; it changes what is measured. A delay of the torque is undone
in the drive. Where part of the inertia is on the measured side of a spring or a play, both sides are moved
(``two_sides``). Where none is, a spring puts the measured side ahead by torque times compliance, a little late by its
damping. Within a play the torque is then zero and does not tell where the measured side is: that is taken from the
recording, behind which the other side is followed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from friction_audit.dynamics.motion import Forward, Model, Motion, Term
from friction_audit.dynamics.move import run_pieces
from friction_audit.dynamics.torque_tables import Tables, certain, tabulate
from friction_audit.dynamics.transmission import HIGHEST_HZ, Transmission, flank_stiffness, straightened
from friction_audit.dynamics.two_mass import Link, can_follow, follow, link_of, move_two_sides
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

SWEEPS = 12
SETTLED = 1e-3
"""Change of the velocity in a sweep at which it has settled, as a share of the velocity."""
RUNAWAY = 100.0
"""A velocity of so many times the largest recorded one is no result."""
SMOOTH_RAD = 0.3
"""Width of the bell under which the torque that twists a spring is averaged, in radians of the far side's ringing: of
that 96 % pass. The rate of the twist multiplies noise of the torque by its frequency."""
LEAST_INERTIA = 1e-3
"""Share of the joint's inertia that terms must leave."""
SOFT = "soft_nm"
"""Ending of the name of a spring's parameter: torque up to which it stiffens."""
BETWEEN = ("delay", "spring", "play")
"""What is between the sensor and the side of friction."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Recording:
    """A recording of the measured side, n samples.

    Attributes:
        motion: The motion.
        drive: Torque at its time, shape (n,). [N m]
        load: Load on the gear that is not in it, shape (n,). [N m]
        pieces: First and last sample of each piece, shape (p, 2).
    """

    motion: Motion
    drive: Float
    load: Float
    pieces: NDArray[np.int64]

    @property
    def step_s(self) -> float:
        """Spacing of the samples. [s]"""
        return float(self.motion.t[1] - self.motion.t[0])

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Samples of the pieces, shape (n,)."""
        inside = np.zeros(len(self.drive), bool)
        for first, last in self.pieces:
            inside[first : last + 1] = True
        return inside


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Moved:
    """Position [rad] and velocity [rad/s] of the side of friction, velocity of the measured side; shape (n,) each."""

    q: Float
    dq: Float
    measured_dq: Float


_Move = Callable[[Tables], _Moved]


def simulate_along(
    model: Model, motion: Motion, drive: Float, pieces: NDArray[np.int64], load: Float | None = None
) -> Float | None:
    """Simulate a joint under a recorded torque.

    Args:
        model: The joint.
        motion: The recording, on an even grid, n samples.
        drive: Torque F_m + u as recorded, shape (n,). [N m]
        pieces: First and last sample of each piece, shape (p, 2).
        load: Load on the gear that is not in the drive; that of the motion where None, shape (n,). [N m]

    Returns:
        Velocity on the measured side, shape (n,) [rad/s]: NaN outside of the pieces; None where it does not settle or
        grows beyond all bounds.
    """
    between = {term.effect.forward: term for term in model.terms if term.effect.forward in BETWEEN}
    if "delay" in between:
        drive = _undelayed(between["delay"], motion, drive)
    load = motion.load if load is None else load
    recording = _Recording(
        motion=motion, drive=drive, load=np.zeros(len(drive)) if load is None else load, pieces=pieces
    )
    acting = [term for term in model.terms if term.effect.forward not in BETWEEN]
    tables, past = tabulate(model.inertia_kg_m2, acting, replace(motion, rest=model.rest(motion)))
    if tables.inertia_kg_m2 <= LEAST_INERTIA * abs(model.inertia_kg_m2):
        return None
    transmission = _transmission(model, motion, between)
    near = 0.0 if transmission is None else (1.0 - transmission.far_share) * model.inertia_kg_m2
    link = None if transmission is None else link_of(transmission, near, tables.inertia_kg_m2 - near)
    if link is not None and can_follow(link, tables, recording.step_s):
        move = _both_sides(recording, link)
    else:
        move = _one_side(recording, _ahead(recording, link, tables))
    return _settle(model, tables, past, recording, move)


def _settle(model: Model, tables: Tables, past: Sequence[Term], recording: _Recording, move: _Move) -> Float | None:
    """Sweep until motion and torque of terms with a past fit each other; return the velocity of the measured side."""
    recorded, inside = recording.motion, recording.inside
    motion, last = recorded, recorded.dq
    for _ in range(SWEEPS):
        found = move(_with_past(tables, past, model, motion))
        velocity = found.dq
        if not (np.abs(velocity[inside]) <= RUNAWAY * np.max(np.abs(recorded.dq))).all():
            return None
        if not past or _rms(velocity[inside] - last[inside]) <= SETTLED * _rms(recorded.dq[inside]):
            return np.where(inside, found.measured_dq, np.nan)
        motion, last = _spliced(recording, found), velocity
    return None


def _both_sides(recording: _Recording, link: Link) -> _Move:
    """Move the measured side, which has inertia, and that of friction."""

    def move(tables: Tables) -> _Moved:
        near = (recording.motion.q, recording.motion.dq)
        far = tables._replace(inertia_kg_m2=tables.inertia_kg_m2 - link.near_kg_m2)
        rows = move_two_sides(recording.drive, recording.load, near, recording.step_s, recording.pieces, link, far)
        return _Moved(q=rows[2], dq=rows[3], measured_dq=rows[1])

    return move


def _one_side(recording: _Recording, ahead: Float) -> _Move:
    """Move the side of friction, of which the measured one is ahead, shape (n,)."""
    motion, step = recording.motion, recording.step_s
    rate = np.gradient(ahead, step)
    q, dq = motion.q - ahead, motion.dq - rate

    def move(tables: Tables) -> _Moved:
        bent = tables.bristles.states_along(q)
        found = run_pieces(step, recording.drive, q, dq, recording.pieces, bent, tables)
        return _Moved(q=found[0], dq=found[1], measured_dq=found[1] + rate)

    return move


def _with_past(tables: Tables, past: Sequence[Term], model: Model, motion: Motion) -> Tables:
    """Add the torque of terms with a past along a motion."""
    known = replace(motion, rest=model.rest(motion))
    for term in past:
        tables = tables._replace(time=tables.time + _ways(term.torque(known), certain(motion), motion.t))
    return tables


def _ways(torque: Float, way: Float, t: Float) -> Float:
    """Torque forwards and backwards, shape (2, n): against the motion or whatever the motion, what jumps less.

    Friction jumps where the direction turns; its level against the motion does not. What is not known where no
    direction is certain is read between.
    """
    sure = way != 0.0
    if not sure.any():
        return np.stack([torque, torque])
    level = np.interp(t, t[sure], (torque * way)[sure])
    turns = np.abs(np.diff(torque[sure])).sum() > np.abs(np.diff((torque * way)[sure])).sum()
    return np.stack([level, -level] if turns else [torque, torque])


def _spliced(recording: _Recording, found: _Moved) -> Motion:
    """Put simulated pieces into a recording."""
    recorded, inside = recording.motion, recording.inside
    ddq = recorded.ddq.copy()
    for first, last in recording.pieces:
        ddq[first : last + 1] = np.gradient(found.dq[first : last + 1], recording.step_s)
    q, dq = np.where(inside, found.q, recorded.q), np.where(inside, found.dq, recorded.dq)
    return replace(recorded, q=q, dq=dq, ddq=ddq)


def _rms(signal: Float) -> float:
    return float(np.sqrt(np.mean(signal**2))) if len(signal) else 0.0


def _transmission(model: Model, motion: Motion, between: Mapping[Forward, Term]) -> Transmission | None:
    """The spring, the play, or both in a row, the spring in the place of the flanks; None without either."""
    spring, play = between.get("spring"), between.get("play")
    compliance = 0.0 if spring is None else _parameter(spring, "_rad_per_nm")
    share = min(_optional(term, "far_share", 1.0) for term in (spring, play))
    gap = 0.0 if play is None else _parameter(play, "_rad")
    if spring is not None and compliance > 0.0:
        return Transmission(
            stiffness_nm_per_rad=1.0 / compliance,
            damping_ratio=_optional(spring, "damping_ratio", 0.0),
            gap_rad=gap,
            soft_nm=_optional(spring, SOFT, 0.0),
            far_share=share,
        )
    if play is None:
        return None
    far_kg_m2, contact_hz = share * model.inertia_kg_m2, _optional(play, "_hz", HIGHEST_HZ)
    return Transmission(
        stiffness_nm_per_rad=flank_stiffness(far_kg_m2, contact_hz, gap, _rms(model.rest(motion))),
        damping_ratio=_optional(play, "damping_ratio", 1.0),
        gap_rad=gap,
        far_share=share,
    )


def _ahead(recording: _Recording, link: Link | None, far: Tables) -> Float:
    """By how far the measured side, without inertia, is ahead of that of friction. [rad], shape (n,)

    Of a play it is what the dead zone takes: how far flanks give way is not told by a position with noise on it.
    """
    motion, drive = recording.motion, recording.drive
    if link is None:
        return np.zeros(len(drive))
    if link.half_rad > 0.0:
        theta = follow(motion.q, motion.dq, recording.load, recording.step_s, link, far)[:, 0]
        return np.clip(motion.q - theta, -link.half_rad, link.half_rad)
    ringing = sqrt(link.stiffness_nm_per_rad / far.inertia_kg_m2)
    torque = _smoothed(drive + recording.load, SMOOTH_RAD / ringing, recording.step_s)
    twist = np.array([straightened(one, link.bend_nm) for one in torque]) / link.stiffness_nm_per_rad
    return _lagging(twist, link.damping_nms_per_rad / link.stiffness_nm_per_rad, recording.step_s)


def _smoothed(signal: Float, time_s: float, step_s: float) -> Float:
    """A signal averaged under a bell curve of a width to either side."""
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(signal, time_s / step_s, mode="nearest"))


def _undelayed(term: Term, motion: Motion, drive: Float) -> Float:
    """The torque at its time; of a load that is late too, what was taken away too early is given back."""
    load = np.zeros(len(drive)) if motion.load is None else motion.load * round(_parameter(term, "delayed_load"))
    return np.asarray(np.interp(motion.t + _delay(term, motion), motion.t, drive + load) - load)


def _delay(term: Term, motion: Motion) -> float:
    """By how much the torque is late: what becomes of one that rises by 1 N m/s. [s]"""
    still = np.zeros(len(motion.t))
    rising = replace(motion, dq=still, ddq=still, rest=motion.t - motion.t[0], load=None)
    return -float(np.median(term.torque(rising)))


def _parameter(term: Term, ending: str) -> float:
    """Return the one parameter of a term whose name has an ending.

    Raises:
        AnalysisError: If there is none, or more than one.
    """
    pairs = zip(term.effect.parameters, term.values, strict=True)
    values = [value for parameter, value in pairs if parameter.name.endswith(ending)]
    if len(values) != 1:
        raise AnalysisError(
            f"term {term.name}: {len(values)} parameters end on {ending}; expected one for a {term.effect.forward}"
        )
    return values[0]


def _optional(term: Term | None, ending: str, default: float) -> float:
    """Return the one parameter of a term whose name has an ending; a default where there is none, or no term."""
    if term is None or not any(parameter.name.endswith(ending) for parameter in term.effect.parameters):
        return default
    return _parameter(term, ending)


def _lagging(signal: Float, time_s: float, step_s: float) -> Float:
    """A signal that follows another one, exactly where that is linear between samples."""
    if time_s <= 0.0:
        return signal
    from scipy.signal import lfilter

    keep = np.exp(-step_s / time_s)
    bend = 1.0 - (1.0 - keep) * time_s / step_s
    following, _ = lfilter([bend, 1.0 - keep - bend], [1.0, -keep], signal, zi=[(1.0 - bend) * signal[0]])
    return np.asarray(following)
