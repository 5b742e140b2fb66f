"""A row of the balance: which torques are removed from the source, with which sign, and what is left in it.

Inertial and Coriolis torque of an arm are evaluated on a coarse grid of times and interpolated at the samples. They
need the acceleration, so the velocity is low-pass filtered without a phase shift before it is differentiated. The
position is smooth and nearly free of noise: it is read at the grid's times without a filter. The measured torque is
never filtered: the energy sums multiply it with the measured velocity.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple, cast

import numpy as np

from friction_audit.joint_log import Float, JointLog
from friction_audit.parallel import WORKERS, per_joint
from friction_audit.preprocessing.interaction import Caution, SignEvidence
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.sign import CoarseLog, most, strokes_of, voting
from friction_audit.preprocessing.torque_source import CHANNELS, Plan, with_a_model
from friction_audit.robot.arm import STANDARD_GRAVITY, read_urdf

SIGNS = {"hand": -1, "robot": 1}  # factor on tau_J and on tau_ext in each row
# Of a real Panda at up to 2 rad/s, all corners from 4 to 10 Hz leave 0.75 N m rms of F_m of joint 2, 20 Hz 0.86, 30 Hz
# 1.09: the motion lies below 4 Hz, the structure shakes at 26 to 28 Hz, where M ddq of a rigid arm is wrong.
CUTOFF_HZ = 10.0
FILTER_ORDER = 4
LARGEST_CUTOFF = 0.4  # of the grid's rate: below the Nyquist frequency, where a slow log leaves no room for the corner
# A hole in the log is a time step longer than both; nothing is filtered or interpolated across it.
HOLE_S = 0.5
HOLE_STEPS = 20
BLOCK = 1 << 16  # samples interpolated at a time
SPLINE_REACH = 20  # knots beyond a block that its spline takes along: their influence falls by 3.7 per step, to 1e-11


class Grid(NamedTuple):
    """A uniform grid of times over one stretch of a log without a hole."""

    samples: int  # of the log in the stretch
    t: Float  # times, from the first sample of the stretch to its last, shape (k,) [s]
    rate_hz: float  # rate asked for; the spacing is a little less than its inverse [Hz]


class GridTorque(NamedTuple):
    """A torque of all joints known on the grids of a log, one array of shape (k, j) per grid. [N m]"""

    grids: tuple[Grid, ...]
    values: tuple[Float, ...]

    def subtract_from(self, torque: Float, t: Float, columns: list[int]) -> None:
        """Subtract the torque of some joints (0-based) from an array in place, whose rows are at increasing times."""
        from scipy.interpolate import CubicSpline

        borders = [0, *np.searchsorted(t, [grid.t[0] for grid in self.grids[1:]]).tolist(), len(t)]
        for grid, values, (start, stop) in zip(self.grids, self.values, pairwise(borders), strict=True):
            for first in range(start, stop, BLOCK):
                rows = slice(first, min(first + BLOCK, stop))
                low, high = np.searchsorted(grid.t, t[rows][[0, -1]])
                knots = slice(max(int(low) - SPLINE_REACH, 0), int(high) + SPLINE_REACH)
                near = np.clip(t[rows], grid.t[0], grid.t[-1])  # in a hole as at its begin, or it leaves all bounds
                torque[rows] -= CubicSpline(grid.t[knots], values[knots, columns])(near)


def grids_of(log: JointLog, rate_hz: float) -> tuple[Grid, ...]:
    """Return grids of this rate (of the log's own, if that is lower), one for each stretch of a log without a hole."""
    rate_hz = min(rate_hz, log.rate_hz)
    holes = log.gaps_longer_than(max(HOLE_S, HOLE_STEPS / log.rate_hz))
    firsts = [(0, 0.0), *((int(row) + 1, after) for row, _, after in holes.tolist())]
    lasts = [*((int(row) + 1, before) for row, before, _ in holes.tolist()), (log.samples, log.duration_s)]
    grids = []
    for (first, start), (end, stop) in zip(firsts, lasts, strict=True):
        # A stretch of one sample has a grid of two times all the same, so that nothing else needs to know.
        stop = stop if end - first > 1 else start + 1 / rate_hz  # noqa: PLW2901
        t = np.linspace(start, stop, int(np.ceil((stop - start) * rate_hz)) + 1)
        grids.append(Grid(samples=end - first, t=t, rate_hz=rate_hz))
    return tuple(grids)


def motion_on(grids: Sequence[Grid], log: JointLog) -> list[tuple[Float, Float, Float]]:
    """Return position [rad], low-pass filtered velocity [rad/s] and acceleration [rad/s^2] on each grid, (k, j)."""
    # Means over the cell of each grid time keep the integral, and are the anti-alias filter.
    own = [grid.t if grid.samples > 1 else np.full(len(grid.t), grid.t[0]) for grid in grids]
    fine = [grid.samples >= 2 * len(grid.t) for grid in grids]
    edges = (np.concatenate([t[:1], (t[1:] + t[:-1]) / 2, t[-1:]]) for t in own)
    times = [edge if one else t for edge, one, t in zip(edges, fine, own, strict=True)]
    positions, found = _along(log, "q", own, [False] * len(own)), _along(log, "dq", times, fine)
    means = (
        np.diff(a, axis=0) / np.diff(t)[:, None] if one else a for a, t, one in zip(found, times, fine, strict=True)
    )
    return [(position, *_smooth(grid, mean)) for grid, position, mean in zip(grids, positions, means, strict=True)]


def _smooth(grid: Grid, mean: Float) -> tuple[Float, Float]:
    from scipy.signal import butter, sosfiltfilt

    sections = butter(FILTER_ORDER, min(CUTOFF_HZ, LARGEST_CUTOFF * grid.rate_hz), fs=grid.rate_hz, output="sos")
    padding = min(int(grid.rate_hz), len(grid.t) - 1)
    velocity = np.column_stack([sosfiltfilt(sections, dq, padlen=padding) for dq in mean.T])
    # Central differences of fourth order, of second order at the ends.
    step = float(grid.t[1] - grid.t[0])
    slope: Float = np.gradient(velocity, step, axis=0)
    slope[2:-2] = (8 * (velocity[3:-1] - velocity[1:-3]) - (velocity[4:] - velocity[:-4])) / (12 * step)
    return velocity, slope


def _along(log: JointLog, channel: str, times: Sequence[Float], integrate: Sequence[bool]) -> list[Float]:
    """Interpolate a channel, or its integral from the beginning of the log, at times along each grid: (k, j) each."""
    found, gone = [np.empty((len(t), len(log.joint_names))) for t in times], np.zeros(len(log.joint_names))
    t, signal = np.empty(0), np.empty((0, len(gone)))
    for part in log.blocks((channel,)):
        # The last sample of the block before comes along, or there were no motion from it on.
        t, signal = np.append(t[-1:], part.t), np.concatenate([signal[-1:], getattr(part, channel)])
        ends = t[0], np.inf if part.first + len(part.t) == log.samples else t[-1]
        places = [slice(*np.searchsorted(wanted, ends).tolist()) for wanted in times]
        for joint, column in enumerate(signal.T):
            integral = column
            if any(integrate):
                area = (column[1:] + column[:-1]) * (np.diff(t) / 2)
                integral = np.cumsum(np.append(gone[joint], area))
                gone[joint] = integral[-1]
            for out, wanted, own, one in zip(found, times, places, integrate, strict=True):
                out[own, joint] = np.interp(wanted[own], t, integral if one else column)
    return found


class Balance(NamedTuple):
    """One row of the balance: F_m = sign * (source - each of the torques removed)."""

    plan: Plan
    drive: str
    sign: int
    inertial: GridTorque | None  # M ddq + c of the model, or None
    source: Float  # at the times of the coarse log, shape (m, j) [N m]
    left: Float  # of it when the others are removed, likewise [N m]
    has_model: bool  # whether a model of the arm removes a torque
    evidence: tuple[SignEvidence, ...] = ()

    @classmethod
    def of(cls, log: JointLog, coarse: CoarseLog, plan: Plan, drive: str, model_rate_hz: float) -> "Balance":
        """Evaluate a row of a log: the source without the torques that the plan removes."""
        arm, inertial, source = plan.arm, None, coarse.mean(getattr(log, CHANNELS[plan.source]))
        weight = log.gravity if plan.gravity == "logged" else None
        left = source.copy() if weight is None else source - coarse.mean(weight)
        if arm is not None and plan.gravity == "model":
            left -= arm.gravity(coarse.q)
        if arm is not None and drive == "robot" and plan.inertia:
            grids = grids_of(log, model_rate_hz)
            torques = [arm.inverse_dynamics(q, dq, ddq) - arm.gravity(q) for q, dq, ddq in motion_on(grids, log)]
            inertial = GridTorque(grids=grids, values=tuple(torques))
            inertial.subtract_from(left, coarse.t, list(range(len(log.joint_names))))
        return cls(
            plan=plan,
            drive=drive,
            sign=1 if plan.source == "interaction" else SIGNS[drive],
            inertial=inertial,
            source=source,
            left=left,
            has_model=plan.gravity == "model" or inertial is not None,
        )

    @property
    def inertia_left(self) -> bool:
        """True if joints that move together leave inertial and Coriolis torque in F_m."""
        by_motors = self.drive == "robot" and self.plan.source == "tau_J"
        return by_motors and self.inertial is None and self.source.shape[1] > 1

    @property
    def formula(self) -> str:
        """The balance in words, for people."""
        source, gravity = self.plan.source, self.plan.gravity
        if source != "tau_J":
            return f"F_m = {'-' if self.sign < 0 else ''}{CHANNELS[source]}"
        removed = ["M ddq", "c"] if self.inertial is not None else []
        removed += ["g"] if gravity in ("logged", "model") else []
        inside = ", gravity included" if gravity == "in-torque" else ""
        if self.drive == "hand":
            return f"F_m = {'g - ' if removed else '-'}tau_J{inside}"
        less = f" - ({' + '.join(removed)})" if len(removed) > 1 else "".join(f" - {name}" for name in removed)
        return f"F_m = tau_J{less}{inside}"

    def driving(self, log: JointLog, coarse: CoarseLog) -> Float:
        """Return F_m + u of all joints at the coarse log's times, shape (m, j). [N m]"""
        torque = self.sign * self.left
        for active in (log.tau_compensation, log.tau_passivity):
            if active is not None:
                torque += coarse.mean(active)
        return torque

    def full(self, log: JointLog, columns: list[int]) -> Float:
        """Return F_m of some joints at every sample of the log or of a part of it, shape (n, len(columns)). [N m]"""
        source, arm, gravity = getattr(log, CHANNELS[self.plan.source]), self.plan.arm, self.plan.gravity
        weight = log.gravity if gravity == "logged" else None
        if self.sign > 0 and weight is None and not self.has_model and len(columns) == source.shape[1]:
            return cast("Float", source)
        torque = np.empty((len(log.t), len(columns)), order="F")
        if arm is not None and gravity == "model":
            pieces = np.array_split(log.q, WORKERS)
            weight = np.concatenate(per_joint(lambda piece: arm.gravity(pieces[piece]), WORKERS))

        def fill(place: int) -> None:
            own, column = torque[:, place], columns[place]
            np.subtract(source[:, column], 0.0 if weight is None else weight[:, column], out=own)
            if self.inertial is not None:
                self.inertial.subtract_from(own[:, None], log.t, [column])
            if self.sign < 0:
                np.negative(own, out=own)

        per_joint(fill, len(columns))
        return torque


# Cautions about a row: its sign, unused options, and gravity or offsets that are left in it.

# An identified model errs by a few tenths of a N m, the vendor's by up to 2; a forgotten hand makes 2 to 3.
LARGEST_NM = 1.5
LEAST_RANGE_RAD = 0.3  # over less, gravity looks like an offset or a spring
LEAST_ACROSS = 0.1  # share of gravity across an axis below which it is vertical: a payload does not load it
LEAST_STROKES = 10
ENOUGH = 20_000  # means of 20 ms; more add nothing about what changes with the position alone
SIGNIFICANCE = 0.01


def not_used(log: JointLog, balance: Balance, settings: TorqueSettings, *, hand: bool) -> Iterator[Caution]:
    """Name options about the arm that change nothing, because the torque needs no model of it."""
    known = balance.plan.arm is not None
    if settings.urdf is not None and not known:
        from friction_audit.robot.urdf import parse_urdf

        parse_urdf(read_urdf(settings.urdf), str(settings.urdf))  # a file that is no arm is refused though not used
    given = (
        ("--payload", settings.payload is not None and not balance.has_model),
        # Even with logged gravity the direction of gravity is the model's.
        ("--urdf", settings.urdf is not None and not (known or hand)),
        ("--gravity-vector", settings.gravity_vector != STANDARD_GRAVITY and not known),
    )
    if unused := [option for option, idle in given if idle]:
        numbers = {"options": unused, "formula": balance.formula, "has_tau_j": log.tau_J is not None}
        yield Caution("model_not_used", numbers=numbers)


def sign_cautions(log: JointLog, balance: Balance, settings: TorqueSettings, *, turned: bool) -> Iterator[Caution]:
    """Yield what the energy shows about the sign, and that inertia is still in the torque."""
    evidence, plan = balance.evidence, balance.plan
    known = {"formula": balance.formula, "case": plan.source}
    if turned:
        yield Caution(code="sign_turned", numbers=known)
    if most(evidence, "falls"):
        yield Caution(code="sign_contradicts_drive", numbers=known)
    elif not most(evidence, "rises") and voting(evidence):
        yield Caution(code="sign_unproved", numbers=known)
    if balance.inertia_left:
        # Where gravity is left too, its caution has the commands.
        command = "" if plan.gravity == "in-torque" else with_a_model(log, replace(settings, inertia="auto"))
        yield Caution(code="inertia_in_torque", numbers={"command": command})
    minority = "falls" if most(evidence, "rises") else "rises" if most(evidence, "falls") else ""
    for one in voting(evidence):
        if one.verdict == minority:
            numbers = {"verdict": one.verdict, "torque": one.against_motion_nm, "error": one.standard_error_nm}
            yield Caution(code="sign_disagrees", joint=one.joint, numbers=numbers)


def gravity_cautions(log: JointLog, coarse: CoarseLog, balance: Balance, columns: list[int]) -> tuple[Caution, ...]:
    """Say on which joints gravity or an offset is left in the torque, unless gravity is declared to be inside.

    The constants of a gravity error are ill-determined over a short range: two of hundreds of newton metres may cancel.
    What a log determines is their torque over the range that the joint moved, and whether it depends on the position.
    """
    gravity, arm = balance.plan.gravity, balance.plan.arm
    mixed = not most(balance.evidence, "rises") or balance.inertia_left
    if gravity == "in-torque" or mixed or log.source.torque_unit != "N m":
        return ()
    torque, alive = balance.driving(log, coarse), [one for one in columns if one + 1 not in log.source.dead_torque]
    direction = None if arm is None else arm.gravity_direction(coarse.q)
    left = per_joint(lambda place: _left(coarse, torque, direction, alive[place]), len(alive))
    found = [one for one in left if one is not None]
    case = gravity if sum(is_large for _, is_large in found) > 1 else ""
    return tuple(replace(one, numbers={**one.numbers, "case": case}) for one, _ in found)


def _left(coarse: CoarseLog, torque: Float, direction: Float | None, column: int) -> tuple[Caution, bool] | None:
    """Return what is left in the torque of a joint, and whether it is more than its friction; None if it is little."""
    moving, sign, stroke = strokes_of(coarse, column)
    if not stroke.size or stroke[-1] + 1 < LEAST_STROKES:
        return None
    rows = np.flatnonzero(moving)
    thin = slice(None, None, max(len(rows) // ENOUGH, 1))
    rows, sign = rows[thin], sign[thin]
    q, dq = coarse.q[rows, column], coarse.dq[rows, column]
    ddq = np.gradient(coarse.dq[:, column], coarse.t)[rows]
    across = np.column_stack([np.sin(q), np.cos(q)]) if direction is None else direction[rows, column]
    plain = np.column_stack([sign, dq, ddq, np.ones(len(q))])
    coefficients, square, square_plain = _fit(plain, across, torque[rows, column])
    at_rest = coefficients[3] + across @ coefficients[4:]
    wide = np.ptp(q) >= LEAST_RANGE_RAD and float(np.hypot(*across.T).max()) >= LEAST_ACROSS
    # The F test of the two columns of gravity, whose distribution is a power. Strokes are independent, not samples.
    gain = max(square_plain - square, 0.0) / max(square, np.finfo(float).tiny)
    by_position = bool(wide and (1.0 + gain) ** (-0.5 * (stroke[-1] + 1 - len(coefficients))) < SIGNIFICANCE)
    mean, rms = float(at_rest.mean()), float(np.sqrt(np.mean(at_rest**2)))
    if (rms if by_position else abs(mean)) <= LARGEST_NM:
        return None
    code, numbers = "gravity_error" if by_position else "torque_offset", {"mean": mean, "rms": rms}
    found = Caution(code, joint=column + 1, numbers={**numbers, "moved": float(np.ptp(q))})
    return found, rms > abs(float(coefficients[0]))


def _fit(plain: Float, across: Float, torque: Float) -> tuple[Float, float, float]:
    """Return the coefficients of all columns, and the sums of squares that these and the plain ones alone leave."""
    columns = np.column_stack([plain, across])
    scale = np.linalg.norm(columns, axis=0).clip(min=np.finfo(float).tiny)
    # Both fits on the triangular factor: a decomposition of all samples takes most of the time.
    triangle = np.asarray(np.linalg.qr(np.column_stack([columns / scale, torque]), "r"), np.float64)
    fits = []
    for count in (columns.shape[1], plain.shape[1]):
        design, right = triangle[:, :count], triangle[:, -1]
        coefficients = np.linalg.lstsq(design, right, rcond=1e-8)[0]
        fits.append((coefficients, float(np.sum((right - design @ coefficients) ** 2))))
    (coefficients, square), (_, square_plain) = fits
    return coefficients / scale, square, square_plain
