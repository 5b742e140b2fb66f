"""JointLog: what was recorded, in SI units and libfranka symbols; LogInBlocks: a log of any length, means in memory."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, UsageError
from friction_audit.parallel import ahead

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]
DERIVATIVE = "derivative"  # name of the velocity that is made from q
MINIMUM_SAMPLES = 2
_MOST_STEPS = 10_000  # of which the median step is taken

# Channels from which the interaction torque can be computed; a log has at least one of them.
TORQUE_CHANNELS = ("tau_interaction", "tau_J", "tau_ext_hat_filtered")


class Finding(NamedTuple):
    """Something noticed about a recording while it was read, with its amount and what was done about it."""

    code: str  # stable short name, e.g. "stale_samples"
    message: str  # one sentence for people: what, how much, what was done
    joint: int | None = None  # its number for people (1..n), or None when the whole log is meant
    amount: float | None = None  # the size of it, in the unit that the message names
    damaged: bool = False  # True if part of the input was lost or left out (exit code 6)


class Joined(NamedTuple):
    """A further file that channels of a log came from: path as given, content hash, name of the reader."""

    path: str
    sha256: str
    format: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Source:
    """Where a log came from and how it was understood."""

    path: str  # as the user gave it
    sha256: str  # content hash of the file (of all files, in sorted order, for a directory)
    format: str  # name of the reader that read it
    robot: str = "unknown"  # name of a preset, or "unknown": by joint names or message types, or as the user said
    serial: str = ""  # serial number of the arm as the file states it
    clock: str = "column"  # or "robot_time", "header_stamp", "log_time"
    start_s: float | None = None  # Unix time of the first sample, or None when the clock does not say [s]
    topic: str | None = None  # read, None for tables
    channels: Mapping[str, str] = field(default_factory=dict)  # channel -> name in the file, {i} for the joint's index
    torque_unit: str = "N m"  # or "A", "mA" where the name of the torque column says motor current
    # Windows of time, over all moving joints, on which q, dq and the clock were compared; 0 if that was not possible.
    clock_windows: int = 0
    findings: tuple[Finding, ...] = ()  # what was noticed about the recording
    window: tuple[float | None, float | None] = (None, None)  # start and end of the part taken, as asked for [s]
    skipped_s: float = 0.0  # time from the first sample of the recording to that of this log [s]
    joined: tuple[Joined, ...] = ()  # further files that channels came from

    @property
    def dead_torque(self) -> frozenset[int]:
        """Numbers (1..n) of moving joints whose torque is constant or a few counts: no estimate, no vote on a sign."""
        return frozenset(found.joint for found in self.findings if found.code == "torque_dead" and found.joint)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Recording:
    """What a report says of a log: its clock, its joints and its source, without the channels."""

    t: Float  # time since the first sample, strictly increasing, t[0] = 0, shape (n,) [s]
    joint_names: tuple[str, ...]  # in the order of the columns
    source: Source
    clock: tuple[int, float, float] | None = field(default=None, init=False)  # as in ``LogInBlocks``; None: that of t

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return self.clock[0] if self.clock else len(self.t)

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample. [s]"""
        return self.clock[1] if self.clock else float(self.t[-1])

    @property
    def rate_hz(self) -> float:
        """Sampling rate, from the median time step. [Hz]"""
        return 1.0 / (self.clock[2] if self.clock else median_step(self.t))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointLog(Recording):
    """A recorded joint log: n samples of j joints; its channels stand in the order in which files have them.

    Arrays of shape (n, j) are float64, finite, read-only, and best laid out column by column (Fortran order):
    every step works through one joint at a time. InputError if a shape, the clock or a value breaks the promise, or no
    torque channel is there.
    """

    q: Float  # joint position [rad]
    dq: Float  # joint velocity [rad/s]
    tau_J: Float | None = None  # measured link-side torque, gravity and payload included [N m]
    tau_J_d: Float | None = None  # desired link-side torque, without gravity [N m]
    tau_ext_hat_filtered: Float | None = None  # the vendor's estimate of the external torque, low-pass filtered [N m]
    gravity: Float | None = None  # gravity torque as logged (libfranka Model::gravity) [N m]
    tau_interaction: Float | None = None  # a column that already is the interaction torque F_m [N m]
    tau_compensation: Float | None = None  # of a friction compensator that was active, with the motion positive [N m]
    tau_passivity: Float | None = None  # of that compensator's passivity controller, logged apart from it [N m]
    temperature: Float | None = None  # of the joint [degC]

    def __post_init__(self) -> None:
        """Prove the invariants and make the arrays read-only."""
        path, t, channels = self.source.path, self.t, self.channels()
        if t.ndim != 1 or t.dtype != np.float64 or len(t) < MINIMUM_SAMPLES:
            raise InputError(f"{path}: {t.size} samples; at least {MINIMUM_SAMPLES} are needed for a joint log")
        if t[0] != 0.0 or not np.isfinite(t[-1]) or not np.all(t[1:] > t[:-1]):
            raise InputError(f"{path}: time must start at 0 and increase strictly")
        shape = len(t), len(self.joint_names)
        for name, array in channels.items():
            if array.shape != shape or array.dtype != np.float64:
                raise InputError(f"{path}: {name} has shape {array.shape} {array.dtype}; expected {shape} float64")
            # A sum is finite only if every term is, up to overflow: one pass and no temporary array.
            if not np.isfinite(array.sum()) and not np.isfinite(array).all():
                raise InputError(f"{path}: {name} holds values that are not finite")
        if not channels.keys() & {*TORQUE_CHANNELS}:
            raise InputError(f"{path}: no torque channel; expected one of {', '.join(TORQUE_CHANNELS)}")
        for array in (t, *channels.values()):
            array.setflags(write=False)

    def __repr__(self) -> str:
        joints, seconds = len(self.joint_names), f"{self.duration_s:.4g} s at {self.rate_hz:.4g} Hz"
        return f"JointLog({self.source.path}: {joints} joints, {seconds}; {', '.join(self.channels())})"

    def channels(self) -> dict[str, Float]:
        """Return the per-joint channels that were recorded, by name, in the order of JOINT_CHANNELS."""
        found = ((name, getattr(self, name)) for name in JOINT_CHANNELS)
        return {name: array for name, array in found if array is not None}

    def blocks(self, names: Collection[str] | None = None) -> "Iterator[LogPart]":  # noqa: ARG002
        """Yield the log, or some of its channels, in parts that follow each other: in memory it is one, with all."""
        yield LogPart(t=self.t, **self.channels(), joint_names=self.joint_names, source=self.source, first=0)

    def gaps_longer_than(self, limit_s: float) -> Float:
        """Return the gaps: number of the sample before each, its time and that of the sample after it, shape (k, 3)."""
        rows = np.flatnonzero(np.diff(self.t) > limit_s)
        return np.column_stack([rows, self.t[rows], self.t[rows + 1]])

    def take_joints(self, columns: Sequence[int]) -> "JointLog":
        """Return the log of some joints only, given by column (0-based)."""
        if tuple(columns) == tuple(range(len(self.joint_names))):
            return self
        kept: dict[str, Any] = {name: array[:, list(columns)] for name, array in self.channels().items()}
        return replace(self, **kept, joint_names=tuple(self.joint_names[c] for c in columns))

    def take_window(self, start_s: float | None, stop_s: float | None) -> "JointLog":
        """Return the samples with start_s <= t < stop_s, two at least; the clock and the recording start at 0 again."""
        if (start_s, stop_s) in ((None, None), self.source.window):  # taken while the log was read: not once more
            return self
        part = find_window(self.t, start_s, stop_s, self.source.path)
        skipped_s = float(self.t[part.start])
        begun = self.source.start_s
        source = replace(
            self.source,
            start_s=None if begun is None else begun + skipped_s,
            window=(start_s, stop_s),
            skipped_s=self.source.skipped_s + skipped_s,
        )
        kept: dict[str, Any] = {name: array[part] for name, array in self.channels().items()}
        return replace(self, t=self.t[part] - skipped_s, source=source, **kept)


JOINT_CHANNELS = tuple(one.name for one in fields(JointLog) if one not in fields(Recording))
"""Channels with one column per joint, in the order in which they are written to files."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogPart(JointLog):
    """Samples of a log that follow each other, on its clock."""

    first: int  # number of the first of them in the log

    def __post_init__(self) -> None:
        """Prove nothing: a part is as its log is."""


def find_window(t: Float, start_s: float | None, stop_s: float | None, path: str) -> slice:
    """Return the samples with start_s <= t < stop_s; UsageError if they are fewer than two."""
    first = 0 if start_s is None else int(np.searchsorted(t, start_s))
    last = len(t) if stop_s is None else int(np.searchsorted(t, stop_s))
    return check_window(first, last, start_s, stop_s, float(t[-1]), path)


def check_window(first: int, last: int, start_s: float | None, stop_s: float | None, end_s: float, path: str) -> slice:
    """Return the samples of a window of time in a log that lasts until ``end_s``; UsageError if fewer than two."""
    if last - first < MINIMUM_SAMPLES:
        raise UsageError(
            f"{path}: {max(last - first, 0)} samples between {start_s or 0:g} s and "
            f"{'its end' if stop_s is None else f'{stop_s:g} s'}; the log lasts from 0 to {end_s:g} s; "
            "choose another --t-start/--t-end"
        )
    return slice(first, last)


def median_step(t: Float) -> float:
    """Return the median time step of a clock, from steps spread evenly over it where there are very many. [s]"""
    first = step_places(len(t))
    return float(np.median(t[first + 1] - t[first]))


def step_places(samples: int) -> Int:
    """Return the samples before the steps of which the median is taken."""
    return np.linspace(0, samples - 2, min(samples - 1, _MOST_STEPS)).astype(np.int64)


def read_only(numbers: Float) -> Float:
    """Return numbers in one read-only piece: loops are compiled once for each mixture of read-only and other arrays."""
    whole = np.ascontiguousarray(numbers, np.float64).view()
    whole.setflags(write=False)
    return whole


# A longer log is judged by means of stretches that are spread evenly over it: 20 min at 50 Hz, in pieces of 20 s.
MOST_MEANS, STRETCH = 60_000, 1 << 10
COARSE_HZ = 50.0  # of the means by which the sign of a torque is proved: above the motion, and cheap for hours of log


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogInBlocks(LogPart):
    """A log that is read in blocks, anew for every pass; its arrays are means over ``mean_of`` samples each."""

    mean_of: int  # samples per mean
    numbers: Int  # number of each mean among those of the whole log, shape (m,)
    clock: tuple[int, float, float]  # number of samples, time of the last one [s], median step [s]
    gaps: Float  # number of the sample before each gap, its time and that of the sample after it, shape (k, 3)
    # Yields the clock of each block, and those of its channels that are asked for.
    read: Callable[[Collection[str]], Iterator[tuple[Float, dict[str, Float]]]]
    read_whole: Callable[[], JointLog]  # reads the log into memory
    listener: Any = None  # what has taken every block while the log was checked, or None

    def take_window(self, start_s: float | None, stop_s: float | None) -> JointLog:
        """Return the samples with start_s <= t < stop_s, in memory; the log itself where it is that part."""
        if (start_s, stop_s) in ((None, None), self.source.window):
            return self
        return self.read_whole().take_window(start_s, stop_s)

    def blocks(self, names: Collection[str] | None = None) -> Iterator[LogPart]:
        """Read the log, or some of its channels, in parts that follow each other; a motion not asked for is NaN."""
        first = 0
        for t, channels in ahead(self.read([name for name in self.channels() if names is None or name in names])):
            nothing = np.broadcast_to(np.nan, (len(t), len(self.joint_names)))
            held = {"q": nothing, "dq": nothing, **channels}
            yield LogPart(t=t, **held, joint_names=self.joint_names, source=self.source, first=first)
            first += len(t)

    def gaps_longer_than(self, limit_s: float) -> Float:
        """Return the gaps: number of the sample before each, its time and that of the sample after it, shape (k, 3)."""
        return self.gaps[self.gaps[:, 2] - self.gaps[:, 1] > limit_s]


def samples_per_mean(step_s: float, samples: int) -> int:
    """Return how many samples of a log are in a mean at COARSE_HZ."""
    return max(1, min(round(1.0 / step_s / COARSE_HZ), samples // 2))


def block_means(signal: Float, samples: int) -> Float:
    """Return the means of neighbouring blocks of samples, shape (n, j) -> (n // samples, j)."""
    blocks = len(signal) // samples
    whole = (np.ascontiguousarray(column[: blocks * samples]).reshape(blocks, samples) for column in signal.T)
    sums = [np.einsum("mi->m", one) for one in whole]  # a quarter of the time of mean()
    return np.asarray(np.stack(sums, axis=1) / samples)


class Means:
    """Gathers means over neighbouring samples, piece by piece; of a long log, in stretches spread evenly over it."""

    def __init__(self, step_s: float, samples: int, names: Collection[str], joints: int) -> None:
        self.of = samples_per_mean(step_s, samples)
        numbers = np.arange(samples // self.of)
        every = -(-len(numbers) // MOST_MEANS)  # of so many stretches one is kept
        self._is_kept = (numbers // STRETCH) % every == 0
        self.numbers = numbers[self._is_kept]
        self.t = np.empty((len(self.numbers), 1))
        self.channels = {name: np.empty((len(self.numbers), joints), order="F") for name in names}
        self._seen, self._kept = 0, 0
        self._rest = {name: np.empty((0, joints)) for name in names} | {"t": np.empty((0, 1))}  # not yet a whole mean

    @property
    def found(self) -> tuple[Float, dict[str, Float]]:
        """Means of the time and of the channels so far."""
        return self.t[: self._kept, 0], {name: means[: self._kept] for name, means in self.channels.items()}

    def take(self, t: Float, channels: dict[str, Float]) -> None:
        """Take the rows of a piece."""
        size, done, first = self.of, self._seen // self.of, -self._seen % self.of
        self._seen += len(t)
        own, left = self._is_kept[done : self._seen // size], self._seen % size
        places = slice(self._kept, self._kept + int(np.count_nonzero(own)))
        self._kept = places.stop
        # The mean that was begun, and those of the piece from the first that is kept to the last.
        begun_too, inside = own[: min(first, 1)], np.trim_zeros(own[min(first, 1) :])
        before = np.argmax(own[min(first, 1) :]) if len(inside) else 0
        rows = slice(first + before * size, first + (before + len(inside)) * size)
        for name, piece in (("t", t[:, None]), *channels.items()):
            begun = np.concatenate([self._rest[name], piece[:first]])
            if own.any():
                found = block_means(begun, size)[begun_too], block_means(piece[rows], size)[inside]
                (self.t if name == "t" else self.channels[name])[places] = np.concatenate(found)
            self._rest[name] = begun if left > len(t) else piece[len(t) - left :].copy()
