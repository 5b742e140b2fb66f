"""EnergyCycles: a structure of arrays, one row per energy cycle of a joint; their borders, and sums over their parts.

An energy cycle is the half-open interval [start, stop) of samples from one termination to the next (paper, section
III): the joint rests at both ends, so its kinetic energy cancels and the work left is what friction took. Sums are
trapezoids over [t[start], t[stop]], on the real stamps; neighbours share the border sample and nothing else.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from friction_audit.joint_log import Bool, Float, Int

# Why a cycle is rejected: kept, a gap in the log, no return to its start while gravity is in the torque, not every
# joint has moved enough, the joint never reversed, longer than energies can be compared over.
KEPT, GAP, OPEN, SMALL, ONE_WAY, LONG = range(6)
REASONS = ("", "gap", "open", "small", "one_way", "long")
# What the energy balance of a part of a cycle is about, the energy last; see ``EnergyCycles.products``.
BALANCE = (
    "path_rad", "speed_over_path_rad2_s", "displacement_rad", "half_square_speed_change",
    "gravity_x_rad", "gravity_y_rad", "dissipated_j",
)  # fmt: skip
PAIRS = np.triu_indices(len(BALANCE))


class EnergySums(NamedTuple):
    """Energy sums over pieces of motion; every array has the same shape."""

    work_j: Float  # integral of F_m over the position, the net energy input [J]
    compensation_j: Float  # integral of u over the position, the energy that a logged compensator put in [J]
    printed_net_j: Float  # integral of (F_m + u) dq dt, the net energy as (2) and (10) print it [J]
    path_rad: Float  # path, with the sign of the filtered velocity: the noise of the velocity adds none at rest [rad]
    rectified_path_rad: Float  # integral of |dq| dt, as (14) prints it [rad]
    square_speed_rad2_s: Float  # integral of dq^2 dt, as (20) prints it [rad^2/s]
    speed_over_path_rad2_s: Float  # the same by the sum of the work, of dq over the position [rad^2/s]
    displacement_rad: Float  # change of q: the work of one newton metre of torque offset [rad]
    # integral of g_x dq dt: the work per newton metre of gravity error along x of the joint's frame
    gravity_x_rad: Float
    gravity_y_rad: Float  # the same along y
    # change of dq^2 / 2 of the filtered velocity: kinetic energy per inertia [rad^2/s^2]
    half_square_speed_change: Float

    @property
    def dissipated_j(self) -> Float:
        """What friction took: the net energy of (10), in signs where a compensator's work counts positive. [J]"""
        return self.work_j + self.compensation_j


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class EnergyCycles:
    """Energy cycles of one joint in the order of time, m rows, and what the search for them found of the joint."""

    start: Int  # first sample, shape (m,)
    stop: Int  # border sample, the next cycle's start, shape (m,)
    start_s: Float  # t[start] [s]
    stop_s: Float  # t[stop] [s]
    peak_speed_rad_s: Float  # largest filtered speed [rad/s]
    sums: EnergySums  # over the whole cycle, arrays of shape (m,)
    # Of parts of equal path, the products of PAIRS of BALANCE over the part's square speed, summed over each cycle; the
    # parts of a day would take most of the memory. Shape (m, len(PAIRS[0])).
    products: Float
    # path, and first and second moment of the mean speed of the parts over it, of those that move, shape (m, 3)
    speeds: Float
    open: Bool  # True where a joint does not end where it began, shape (m,)
    reason: Int  # index into REASONS; KEPT where the cycle counts, shape (m,)
    initiation: float  # threshold used [speed_unit]
    termination: float  # the other one [speed_unit]
    speed_unit: str  # ``"rad/s"``, or ``"m/s"`` where the hand defines the cycles
    # speed below which a direction means nothing: the joint's own termination threshold in any case [rad/s]
    standstill_rad_s: float
    # Known at the end of the log.
    fastest: float = 0.0  # largest filtered speed in the log of what the thresholds are for [speed_unit]
    moving_s: float = 0.0  # time above the initiation threshold [s]
    peak_power_w: float = 0.0  # largest power of F_m + u in the log [W]

    def rows(self, mask: Bool) -> "EnergyCycles":
        """Return the rows selected by a mask of shape (m,)."""
        return self.made_of(lambda own: own[0][mask])

    def made_of(self, of: Callable[[list[Any]], Any], later: Sequence["EnergyCycles"] = ()) -> "EnergyCycles":
        """Return the structure whose arrays are a function of the arrays of these cycles and of later ones."""
        every = [self, *later]
        names = [one.name for one in fields(self) if isinstance(getattr(self, one.name), np.ndarray)]
        arrays = {name: of([getattr(one, name) for one in every]) for name in names}
        sums = EnergySums(*(of([*own]) for own in zip(*(one.sums for one in every), strict=True)))
        return replace(self, **arrays, sums=sums)


# Sums of ``add_up``, with the names of ``EnergySums``.
PRINTED = "printed_net_j", "rectified_path_rad", "square_speed_rad2_s"  # with dq dt, as in the paper
SUMS = ("work_j", "compensation_j", "path_rad", "speed_over_path_rad2_s", *PRINTED)
BLOCK = 1 << 17  # samples worked on at a time: of fewer, threads would mostly wait for the interpreter


def find_borders(
    velocity: Float,
    initiation: float,
    termination: float,
    *,
    merge: bool,
    moving: bool | None = None,
    at_border: bool | None = None,
    more: bool = False,
    longest: int = sys.maxsize,
) -> Int:
    """Return the samples that separate energy cycles, shape (m + 1,); empty without a complete cycle at the end.

    A cycle begins when the speed exceeds ``initiation`` and is over when it falls below ``termination``. The border
    lies where the joint then comes to rest, the first sample at which the velocity is zero or has changed its sign,
    or else the slowest sample before the next cycle begins: there the kinetic energy is gone and not merely small.
    With ``merge``, two humps between which the filtered velocity never changes its sign are one stroke; a speed, which
    has no sign, is not merged. ``moving`` and ``at_border`` say what the first sample is; None if its own speed
    decides, and if it is a border at rest. If ``more`` samples follow, borders that these may move are left out. The
    slowest sample is looked for among the ``longest`` number after the end of a motion.
    """
    moving = bool(abs(velocity[0]) > termination) if moving is None else moving
    stops, starts, turns = events(velocity, initiation, termination, moving=moving)
    borders = [0] if (not moving if at_border is None else at_border) else []
    if not moving:
        starts = starts[1:]  # the first rest lasts from the first sample and ends at the first start
    length = len(velocity)
    ends = np.append(starts, length)
    turned = np.append(turns, length)[np.searchsorted(turns, stops)]
    for stop, end, turn in zip(stops.tolist(), ends.tolist(), turned.tolist(), strict=False):
        reach = min(end, stop + longest)
        if turn < reach:
            borders.append(turn)
        elif more and reach == length:
            break
        elif not (merge and reach == end < length and borders and velocity[end] * velocity[stop - 1] > 0.0):
            borders.append(stop + int(np.argmin(np.abs(velocity[stop:reach]))))
    return np.array(borders if more or len(borders) > 1 else [], np.int64)


def events(velocity: Float, initiation: float, termination: float, *, moving: bool) -> tuple[Int, Int, Int]:
    """Return the samples at which motion stops and starts, in turns, and those at which the velocity turns."""
    found: tuple[list[Int], list[Int], list[Int]] = ([], [], [])
    for first in range(0, len(velocity), BLOCK):
        speed = np.abs(velocity[first : first + BLOCK])
        # Between both thresholds the joint keeps the state of the sample before: it changes at one of these edges.
        slow, fast = (
            np.flatnonzero(np.append(one[:1], one[1:] > one[:-1])) for one in (speed < termination, speed > initiation)
        )
        known = np.append(slow, fast)
        order = np.argsort(known)
        states = order >= len(slow)
        changes = states != np.append(moving, states[:-1])
        moving = bool(states[-1]) if len(states) else moving
        for into, place in zip(found, (~states & changes, states & changes), strict=False):
            into.append(first + known[order[place]])
        begin = max(first - 1, 0)
        near = velocity[begin : first + BLOCK]
        found[2].append(begin + 1 + np.flatnonzero(near[1:] * near[:-1] <= 0.0))
    stops, starts, turns = (np.concatenate(one) for one in found)
    return stops, starts, turns


def groups(borders: Int) -> Iterator[slice]:
    """Yield groups of neighbouring cycles that together hold about a block of samples, one cycle at least."""
    first, cycles = 0, len(borders) - 1
    while first < cycles:
        last = max(int(np.searchsorted(borders, borders[first] + BLOCK, side="right")) - 1, first + 1)
        yield slice(first, last)
        first = last


def cut_evenly(step: Float, speed: Float, borders: Int, parts: int) -> tuple[Int, Float]:
    """Cut each cycle into parts of equal path by the filtered velocity ``speed``, given the steps of the clock.

    Return the border samples of the parts, shape (m, parts + 1), the last parts empty in a cycle of few samples, and
    the peak speed [rad/s] of each cycle, shape (m,).
    """
    cycles = len(borders) - 1
    edges, peak = np.empty((cycles, parts + 1), np.int64), np.zeros(cycles)
    for group in groups(borders):
        begin = int(borders[group.start])
        own = borders[group.start : group.stop + 1] - begin
        start, stop = own[:-1], own[1:]
        fast = np.abs(speed[begin : begin + int(stop[-1]) + 1])
        peak[group] = np.maximum.reduceat(fast[:-1], start)
        gone = np.zeros(len(fast))
        np.add(fast[1:], fast[:-1], out=gone[1:])
        gone[1:] *= step[begin : begin + len(fast) - 1]
        np.cumsum(gone, out=gone)
        targets = gone[start, None] + np.diff(gone[own])[:, None] * (np.arange(1, parts) / parts)
        place = np.searchsorted(gone, targets)  # the samples up to which these shares of the path are gone
        # A part holds one sample at least, as long as there are enough of them for the parts that are left.
        order = np.arange(parts - 1)
        place = np.maximum.accumulate(np.maximum(place, start[:, None] + 1) - order, axis=1) + order
        room = np.logical_and.accumulate(stop[:, None] - place >= parts - order, axis=1)
        inner = np.where(room, place, stop[:, None])
        edges[group] = begin + np.column_stack([start, inner, stop])
    return edges, peak


def add_up(
    t: Float, q: Float, dq: Float, filtered: Float, torque: Float, compensation: Float | None, edges: Int
) -> dict[str, Float]:
    """Add up energies between samples by the trapezoid rule, shape (m, parts) each, with the names of ``EnergySums``.

    Work and its columns are summed over the increments of q: they scale alike with any error of the clock and of the
    trapezoids, and the noise of the velocity adds nothing. ``edges`` are the border samples of the parts of each cycle,
    shape (m, parts + 1); all else has shape (n,).
    """
    found = np.zeros((len(SUMS), len(edges), edges.shape[1] - 1))
    for group in groups(np.append(edges[:, 0], edges[-1:, -1])):
        own = edges[group] - edges[group.start, 0]
        rows = slice(int(edges[group.start, 0]), int(edges[group.stop - 1, -1]) + 1)
        signals = [None if one is None else one[rows] for one in (dq, filtered, torque, compensation)]
        # A sample counts for the steps on both of its sides, at the borders of a part for one of them.
        areas = _areas(*(_both_steps(one[rows]) for one in (t, q)), *signals)
        before = np.maximum(own - 1, 0)
        steps = ((one[rows][own] - one[rows][before]) for one in (t, q))
        at_borders = _areas(*steps, *(None if one is None else one[own] for one in signals))
        whole = np.add.reduceat(areas, own[:, :-1].ravel(), axis=1).reshape(len(SUMS), len(own), -1)
        found[:, group] = 0.5 * (whole * (np.diff(own) > 0) + np.diff(at_borders))
    return dict(zip(SUMS, found, strict=True)) | {"half_square_speed_change": 0.5 * np.diff(filtered[edges] ** 2)}


def _both_steps(x: Float) -> Float:
    """Return how far it is from the sample before each sample to the one after, 0 at the last."""
    steps = np.zeros(len(x))
    steps[:1] = x[1:2] - x[:1]
    np.subtract(x[2:], x[:-2], out=steps[1:-1])
    return steps


def _areas(step: Float, moved: Float, dq: Float, filtered: Float, torque: Float, compensation: Float | None) -> Float:
    """Return what each of the sums adds up, shape (k, ...)."""
    found = np.empty((len(SUMS), *step.shape))
    work, by_active, path, speed_over_path, printed, rectified, square = found
    np.multiply(torque, moved, out=work)
    moved_by_dq, driving = dq * step, torque if compensation is None else torque + compensation
    np.multiply(0.0 if compensation is None else compensation, moved, out=by_active)
    np.multiply(driving, moved_by_dq, out=printed)
    np.multiply(np.sign(filtered, out=path), moved, out=path)
    np.abs(moved_by_dq, out=rectified)
    np.multiply(dq, moved_by_dq, out=square)
    np.multiply(dq, moved, out=speed_over_path)
    return found
