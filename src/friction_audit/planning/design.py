"""Limits of a joint's motion, candidate motions within them, and the T-optimal design: which of them, how often.

Candidates are short excursions from rest to rest at the start. The competing effects shall differ most.

A. C. Atkinson and V. V. Fedorov (Biometrika 62 (1975) 57): with one effect true, the best fit of another one leaves a
sum of squares; over the variance of the noise it is the expected 2 ln of the likelihood ratio between the two. The
design makes the sum over all pairs of ln(1 + that) large (a compound criterion), by adding the candidate with the
largest gain per second and then exchanging candidates as long as one gains (V. V. Fedorov, Theory of Optimal
Experiments, 1972). Sums of squares add up over candidates, for each starts and ends at rest.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.noise import NoiseModel
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import same_as
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.joint_log import Float, Int
from friction_audit.planning.task import Joint, subject_of
from friction_audit.presets import PRESETS
from friction_audit.robot.arm import read_urdf
from friction_audit.robot.urdf import limits_in
from friction_audit.simulation.strokes import PEAK, Prescribed, Stroke, start_times

# Where the highest acceleration is published, a quarter of it, with this jerk: as joint_limits.yaml of
# panda_moveit_config (moveit_resources) does for the Panda.
ACCELERATION_SHARE, JERK_RAD_S3 = 0.25, 300.0
USUAL = (1.5, 2.5, 100.0)  # rad/s, rad/s^2, rad/s^3: below the limits of all common arms
HAND = (1.8, 8.0, 150.0)  # what a person does with ease; slower than this a person is not steady:
HAND_SLOWEST, ROBOT_SLOWEST = 0.05, 0.01  # rad/s
MARGIN_RAD = 0.05  # kept from the ends of the joint's range
LEAST_RANGE_RAD = 0.02  # below it no candidate motion has a certain direction for long


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of one joint."""

    start_rad: float  # where the motion starts and ends
    low_rad: float
    high_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    jerk_rad_s3: float
    slowest_rad_s: float  # slowest steady speed
    source: str  # where they come from

    def __post_init__(self) -> None:
        if not self.low_rad <= self.start_rad <= self.high_rad:
            where = f"outside of {self.low_rad:.3g} to {self.high_rad:.3g} rad, where the joint may move"
            raise UsageError(f"start {self.start_rad:.3g} rad: {where}; give another --start, or --range")
        if (width := self.high_rad - self.low_rad) < LEAST_RANGE_RAD:
            raise UsageError(f"{width:.3g} rad of range: expected at least {LEAST_RANGE_RAD:g}; widen --range")
        rates, least = (self.speed_rad_s, self.acceleration_rad_s2, self.jerk_rad_s3), 2.0 * self.slowest_rad_s
        if not all(0.0 < rate < inf for rate in rates) or self.speed_rad_s < least:
            found = f"limits of {rates[0]:g} rad/s, {rates[1]:g} rad/s^2 and {rates[2]:g} rad/s^3"
            expected = f"expected a speed of at least {least:g} rad/s, and others above zero"
            raise UsageError(f"{found}: {expected}; raise --speed, --acceleration or --jerk")


def limits_of(
    joint: Joint,
    start_rad: float,
    *,
    urdf: Path | None,
    robot: str = "",
    range_rad: tuple[float, ...] | None = None,
    **asked: float | None,
) -> Limits:
    """Return the limits of a joint: those of the arm, tightened to those of a hand, replaced by what is asked for.

    The range is relative to the start; what is asked for are rates by the names of ``Limits``, None: the arm decides.
    """
    low, high, speed = -inf, inf, inf
    acceleration, jerk, source = (*USUAL[1:], "usual of arms")
    if urdf is not None:
        low, high, speed = limits_in(read_urdf(urdf), str(urdf), joint.name)
        source = f"{urdf.name}; acceleration and jerk {source}"
    elif robot in PRESETS and joint.number <= len(PRESETS[robot].joints):
        preset, k = PRESETS[robot], joint.number - 1
        low, high, speed = preset.low_rad[k], preset.high_rad[k], preset.speed_rad_s[k]
        if preset.acceleration_rad_s2:
            acceleration, jerk = ACCELERATION_SHARE * preset.acceleration_rad_s2[k], JERK_RAD_S3
            source = f"{preset.source}; a quarter of the acceleration, jerk of panda_moveit_config"
        else:
            source = f"{preset.source}; acceleration and jerk {source}"
    if joint.hand:
        speed, acceleration, jerk = map(min, (speed, acceleration, jerk), HAND)
        source = f"{source}; at most those of a person"
    below, above = range_rad or joint.reach_rad
    rates = {"speed_rad_s": USUAL[0] if speed == inf else speed}
    rates |= {"acceleration_rad_s2": acceleration, "jerk_rad_s3": jerk}
    return Limits(
        start_rad=start_rad,
        low_rad=max(low + MARGIN_RAD, start_rad + below),
        high_rad=min(high - MARGIN_RAD, start_rad + above),
        slowest_rad_s=HAND_SLOWEST if joint.hand else ROBOT_SLOWEST,
        source=source,
        **(rates | {key: value for key, value in asked.items() if value is not None}),
    )


BEND = 10.0 / np.sqrt(3.0)  # largest second derivative of the velocity of ``strokes.min_jerk``
REST_S = 0.4  # after an excursion: its cycles end there
LONGEST_S = 3.0  # of a slow ramp one way: slower ones go less far
# What it is, positions to go to, speeds, rest after each stroke, and whether strokes have no constant speed.
Excursion = tuple[str, Sequence[float], ArrayLike, float, bool]
ROUNDING_RAD = 1e-6  # of a side without room
SHARP_S = 0.15  # a person or a motor without overshoot takes at least so long to reach a speed


@dataclass(frozen=True, slots=True)
class Candidate:
    """An excursion: what it is, in words, and its strokes."""

    words: str
    strokes: tuple[Stroke, ...]
    duration_s: float  # its length with the rests [s]
    span_rad: tuple[float, float]  # lowest and highest position relative to the start [rad]


def candidates_of(limits: Limits) -> list[Candidate]:
    """Return the candidate excursions."""
    low, high = limits.low_rad - limits.start_rad, limits.high_rad - limits.start_rad
    fast, slowest = _stroke(high - low, np.inf, limits).speed_rad_s, limits.slowest_rad_s
    if fast < 4.0 * slowest:
        found = f"the fastest motion over {high - low:.3g} rad has {fast:.2g} rad/s; expected at least {4 * slowest:g}"
        raise UsageError(f"limits: {found}; widen --range or raise --speed, --acceleration or --jerk")
    candidates = []
    for words, positions, speeds, rest_s, smooth in _excursions(low, high, fast, limits):
        moved = np.diff([0.0, *np.clip(positions, low, high)])
        pairs = zip(moved.tolist(), np.broadcast_to(np.asarray(speeds, float), moved.shape).tolist(), strict=True)
        strokes = [_stroke(*one, limits, rest_s=rest_s, smooth=smooth) for one in pairs if abs(one[0]) > ROUNDING_RAD]
        strokes[-1] = strokes[-1]._replace(rest_s=max(REST_S, rest_s))
        reached = np.cumsum([0.0, *(one.displacement_rad for one in strokes)])
        span, duration_s = (float(reached.min()), float(reached.max())), sum(one.duration_s for one in strokes)
        candidates.append(Candidate(words, tuple(strokes), duration_s, span))
    return candidates


def _excursions(low: float, high: float, fast: float, limits: Limits) -> Iterator[Excursion]:
    slowest, inner = limits.slowest_rad_s, max(min(-low, high), 0.02)  # half a width that fits on the wider side
    for speed in np.geomspace(slowest, fast, 7):
        up, down = (float(np.clip(end, -speed * LONGEST_S, speed * LONGEST_S)) for end in (high, low))
        words = f"steady at {speed:.2g} rad/s, there and back to both sides"
        yield words, [up, 0.0, down, 0.0], speed, 0.3, False
    ends = [high, low, high, low, 0.0]
    for speed in (0.25 * fast, 0.5 * fast, fast):
        yield f"swing from end to end without rest, peak {speed:.2g} rad/s", ends, speed, 0.0, True
    for reach, share in product((0.1, 0.3), (0.4, 1.0)):
        position = reach * (high - low) / 2.0
        speed = share * _stroke(2.0 * position, np.inf, limits).speed_rad_s
        positions = [*(min(position, inner) * (-1) ** np.arange(10)), 0.0]
        words = f"10 quick reversals over {2 * abs(positions[0]):.2g} rad, peak {speed:.2g} rad/s"
        yield words, positions, speed, 0.0, True
    positions = [*np.linspace(0.0, high, 4)[1:], *np.linspace(high, low, 7)[1:], *np.linspace(low, 0.0, 4)[1:]]
    speed = max(0.15 * fast, 2.0 * slowest)
    for rest_s in (0.15, 0.6, 2.0):
        words = f"12 steps through the range with rests of {rest_s:g} s, peak {speed:.2g} rad/s"
        yield words, positions, speed, rest_s, True
    for up, down in ((0.15 * fast, 0.8 * fast), (0.8 * fast, 0.15 * fast)):
        words = f"up at {up:.2g} rad/s and down at {down:.2g} rad/s"
        yield words, ends, [up, down, up, down, up], 0.0, False
    lengths = np.geomspace(0.02, 0.2, 8) if slowest > 0.02 else np.geomspace(1e-3, 0.03, 12)  # noqa: PLR2004 - by hand
    lengths = lengths[lengths < min(high - low, 1.0)] / 2.0
    if len(lengths) > 2 and -low > lengths[-1] < high:  # noqa: PLR2004 - some
        positions = [*(lengths * (-1.0) ** np.arange(len(lengths))), 0.0]
        words = f"{len(lengths)} small reversals of growing length, {2 * lengths[0]:.2g} to {2 * lengths[-1]:.2g} rad"
        yield words, positions, 2.0 * np.abs(np.diff([0.0, *np.clip(positions, low, high)])), 0.05, True
    sides = np.linspace(0.2, 1.0, 6) * (-1.0) ** np.arange(6)
    positions = [*(min(abs(side), inner) * np.sign(side) for side in sides * (high - low) / 2.0), 0.0]
    yield "chirp: swings of growing width and speed", positions, np.linspace(0.2, 1.0, 7) * fast, 0.0, True


def _stroke(displacement: float, speed: float, limits: Limits, *, rest_s: float = 0.0, smooth: bool = False) -> Stroke:
    """Return a stroke at a speed, or as fast as the limits allow; smooth ones have no constant speed."""
    length = abs(displacement)
    bell = ((limits.acceleration_rad_s2 * length / PEAK) ** 0.5, (limits.jerk_rad_s3 * length**2 / BEND) ** (1 / 3))
    speed = min(speed, limits.speed_rad_s, length / SHARP_S, *bell)
    needed = max(PEAK * speed / limits.acceleration_rad_s2, (BEND * speed / limits.jerk_rad_s3) ** 0.5, SHARP_S)
    return Stroke(displacement, speed, min(length / speed if smooth else needed, length / speed), rest_s)


# The design.

MOST_POINTS = 16  # of an effect's grid: neighbours differ little
ENOUGH = 20.0  # of 2 ln of a likelihood ratio: from 10 on evidence is very strong (Kass, Raftery)
OTHERS = 0.1  # weight of effects that the log has ruled out: the new log must rule them out again
SWEEPS = 4  # of exchanges; two usually suffice
RIDGE = 1e-9


class Information(NamedTuple):
    """Sums of squares and products of whitened columns, by candidate; c candidates, h true effects, k competitors."""

    rows: Float  # of nominal model, nuisances and a competing effect with themselves, shape (c, k, r, r)
    cross: Float  # of these with the torques of the true effects, shape (c, k, r, h)
    own: Float  # of each torque with itself, shape (c, h)
    names: NDArray[np.str_]  # effect of each competitor, of which several are points of one grid, shape (k,)
    truths: tuple[str, ...]  # names of the true effects
    prior: Float  # precision of the rows, shape (r, r)
    seconds: Float  # length of each candidate [s]

    def separation(self, counts: Float) -> tuple[tuple[str, ...], Float]:
        """Return the competing names, and of designs (..., c) the 2 ln of each ratio, shape (..., h, names)."""
        rows = np.tensordot(counts, self.rows, 1) + self.prior
        cross, own = np.tensordot(counts, self.cross, 1), counts @ self.own
        scale = np.sqrt(np.einsum("...rr->...r", rows)) + 1e-300
        scaled = rows / scale[..., None] / scale[..., None, :] + RIDGE * np.eye(rows.shape[-1])
        cross = cross / scale[..., None]
        left = own[..., None, :] - np.einsum("...rh,...rh->...h", cross, np.linalg.solve(scaled, cross))
        names = tuple(dict.fromkeys(self.names.tolist()))
        found = np.stack([left[..., self.names == name, :].min(axis=-2) for name in names], axis=-1)
        return names, np.maximum(found, 0.0)


def information_of(
    joint: Joint,
    candidates: Sequence[Candidate],
    truths: Mapping[str, FittedTerm],
    certain: Sequence[FittedTerm],
    competing: Sequence[Effect],
) -> Information:
    """Simulate the joint along all candidates; one of the ``truths`` is there, and the ``certain`` in any case."""
    motion = Prescribed(strokes=tuple(one for c in candidates for one in c.strokes))
    data = subject_of(joint, joint.settings(motion, float(start_times(motion)[-1]) + 0.5), seed=1).data
    problem = RegressionProblem.build(data, None)
    nominal = joint.nominal(data)
    nuisances, moved = problem.nuisances(nominal, problem.X), data.motion(nominal.torque)
    known = [problem.samples.of(np.sum([term.torque(moved) for term in certain], axis=0))] if certain else []
    base = np.vstack([problem.X, *(one.column for one in nuisances), *known])
    fit = np.linalg.lstsq(base.T, problem.y)[0]
    noise = NoiseModel.fit(problem.age, [problem.y - fit @ base], problem.model_error(nominal))
    each = [problem.samples.of(term.torque(moved)) for term in truths.values()]
    torques = np.reshape(each, (len(truths), len(problem.y)))
    grids: dict[str, list[Block]] = {}
    for block in Dictionary.build(problem, competing, nominal).blocks:
        grids.setdefault(block.name, []).append(block)
    blocks = [block for grid in grids.values() for block in grid[:: max(1, len(grid) // MOST_POINTS)]]
    ends = np.cumsum([len(c.strokes) for c in candidates])
    place = np.searchsorted(start_times(motion)[ends], problem.samples.t, side="right")
    slices = [np.flatnonzero(place == k) for k in range(len(candidates))]
    if not blocks or not len(problem.y):
        raise AnalysisError("no candidate motion shows any effect; widen the limits")
    width = max(b.p for b in blocks)
    white, seen = noise.whiten(base), noise.whiten(torques)
    shape = (len(candidates), len(blocks), len(base) + width)
    rows, cross = np.zeros((*shape, shape[2])), np.zeros((*shape, len(torques)))
    for k, block in enumerate(blocks):
        own = np.vstack([white, noise.whiten(block.columns), np.zeros((width - block.p, len(problem.y)))])
        for c, at in enumerate(slices):
            part = own[:, at]
            rows[c, k], cross[c, k] = part @ part.T, part @ seen[:, at].T
    prior = np.zeros(shape[2])
    prior[len(problem.X) : len(problem.X) + len(nuisances)] = [1.0 / one.sd**2 for one in nuisances]
    size = np.stack([np.sum(seen[:, at] ** 2, axis=1) for at in slices])
    names, seconds = np.array([b.name for b in blocks]), np.array([c.duration_s for c in candidates])
    return Information(rows, cross, size, names, tuple(truths), np.diag(prior) + RIDGE * np.eye(shape[2]), seconds)


def value_of_separation(about: Information, counts: Float) -> Float:
    """Return the compound T-criterion of designs (..., c)."""
    names, found = about.separation(counts)
    weight = np.array([1.0 if name in about.truths else OTHERS for name in names])
    same = [[name in same_as(one) for name in names] for one in about.truths]
    return np.asarray(np.sum(np.where(same, 0.0, weight) * found / (found + ENOUGH), axis=(-2, -1)))


def value_for_coefficients(about: Information, counts: Float) -> Float:
    """Return the D-criterion of inertia, Coulomb and viscous friction of designs, the rest of the model free."""
    first = (np.tensordot(counts, about.rows[:, 0], 1) + about.prior)[..., :3, :3]
    return np.asarray(np.linalg.slogdet(first + RIDGE * np.eye(3))[1])


Criterion = Callable[[Information, Float], Float]


def exchange(about: Information, criterion: Criterion, duration_s: float) -> Int:
    """Return how often each candidate is run in a time [s], shape (c,), with the value of a design by a criterion."""
    counts, units = np.zeros(len(about.seconds)), np.eye(len(about.seconds))
    best = float(criterion(about, counts))

    def one_more(counts: Float) -> tuple[NDArray[np.intp], Float]:
        fits = np.flatnonzero(about.seconds <= duration_s - counts @ about.seconds)
        return fits, criterion(about, counts + units[fits])

    while True:
        fits, values = one_more(counts)
        if not len(fits):
            break
        chosen = int(np.argmax((values - best) / about.seconds[fits]))
        counts, best = counts + units[fits[chosen]], float(values[chosen])
    for _ in range(SWEEPS):
        before = best
        for out in np.flatnonzero(counts):
            fits, values = one_more(counts - units[out])  # never none: what is taken out fits
            if values.max() > best + 1e-9:
                counts, best = counts - units[out] + units[fits[int(np.argmax(values))]], float(values.max())
        if best <= before + 1e-9:
            break
    return counts.astype(np.int64)


def in_order(candidates: Sequence[Candidate], counts: Int) -> tuple[Candidate, ...]:
    """Return the runs spread over the time, so that neither warming up nor drift goes with one of them."""
    times = [((k + 0.5) / count, n) for n, count in enumerate(counts) for k in range(count)]
    return tuple(candidates[n] for _, n in sorted(times))
