"""A recording as a reader returns it, in memory or read block by block; what is gathered of it piece by piece."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import DERIVATIVE, Bool, Finding, Float, Int
from friction_audit.parallel import ahead

Block = tuple[Float, dict[str, Float]]  # clock and channels of samples that follow each other
# Of the parabola whose slope is the velocity: shorter than a change of direction by hand. Of a coarse position it is
# longer, until the slope has little noise: jitter that looks like motion adds path, and takes Coulomb friction away.
# It ends at the least mean square error of the slope: a long parabola cuts fast motion.
HALF_WINDOW_S, LONGEST_HALF_WINDOW_S, NOISE_RAD_S = 0.01, 0.05, 1e-3
MEAN_OF_SIXTH = np.sqrt(924.0 * 2.0 / np.pi)  # absolute sixth difference of white noise, over its standard deviation
_UNEVEN = 0.05  # share by which the steps of the clock may differ where a quartic stands
_TURN_RAD = 2.001 * np.pi
_PIECE = 1 << 16  # samples of a recording in memory that are looked at at a time: they stay in the processor's cache
MOST_SAMPLES = 1 << 16  # from which quantiles are taken, for speed
LAG = 3  # changes are taken over three rows: neighbouring rows of a slow or coarse channel are often equal


class WholeLogError(Exception):
    """A recording cannot be read block by block: what is wrong with it needs all samples at once."""


class Blocks(NamedTuple):
    """A recording that is read block by block, anew for every pass."""

    rows: int  # number of samples
    # Yields the clock and the channels that are asked for, where there are several groups of rows from a group on.
    read: Callable[..., Iterator[Block]]
    groups: Sequence[int] = (0,)  # first rows of groups
    found: Mapping[str, Any] = {}  # by the checks, of what ``LogInBlocks`` has


class Marks:
    """Marks on rows of a recording, one bit each: those of a day at 1 kHz take 11 MB."""

    def __init__(self, rows: int) -> None:
        self._rows, self._bits, self.count = rows, np.empty(0, np.uint8), 0

    def add(self, first: int, marked: Bool) -> None:
        """Mark some of the rows from a first one on."""
        if not marked.any():
            return
        if not self.count:
            self._bits = np.zeros(self._rows // 8 + 2, np.uint8)
        self.count += int(np.count_nonzero(marked & ~self.of(first, len(marked))))
        packed = np.packbits(np.append(np.zeros(first % 8, np.bool_), marked))
        self._bits[first // 8 : first // 8 + len(packed)] |= packed

    def of(self, first: int, count: int) -> Bool:
        """Return which of so many rows from a first one on are marked."""
        if not len(self._bits):
            return np.zeros(count, np.bool_)
        bits = np.unpackbits(self._bits[first // 8 : (first + count) // 8 + 1])
        return bits[first % 8 : first % 8 + count].view(np.bool_)


def sample_rows(rows: int, first: int = 0) -> Int:
    """Return the rows, from this one on, that are taken of a recording with so many, spread evenly, shape (m,)."""
    return np.arange(first, rows, max(rows // MOST_SAMPLES, 1))


class Picked:
    """Values at some rows of a recording, gathered piece by piece."""

    def __init__(self, places: Int, *shape: int) -> None:
        self.places, self.values = places, np.empty((len(places), *shape), order="F")

    def take(self, first: int, piece: Float) -> None:
        """Take those of a piece whose first row has this number."""
        start, stop = np.searchsorted(self.places, (first, first + len(piece)))
        self.values[start:stop] = piece[self.places[start:stop] - first]


class Thinned:
    """At most so many of a long series of numbers, evenly spread over it, however it is cut into pieces."""

    MOST = 1 << 20

    def __init__(self) -> None:
        self._pieces: list[Float] = []
        self._kept, self._every, self._seen = 0, 1, 0

    def take(self, values: Float) -> None:
        """Take the numbers that come next."""
        self._pieces.append(values[-self._seen % self._every :: self._every].copy())
        self._kept, self._seen = self._kept + len(self._pieces[-1]), self._seen + len(values)
        while self._kept > self.MOST:
            self._pieces, self._every = [self.values[::2].copy()], 2 * self._every
            self._kept = len(self._pieces[0])

    @property
    def values(self) -> Float:
        """The numbers that were kept."""
        return np.concatenate(self._pieces)


class Column:
    """What a pass finds of one channel of all joints."""

    def __init__(self, rows: int, joints: int, to_zero: float) -> None:
        """Take the least jump to or from zero that is to be noticed."""
        # Values of rows spread evenly over the recording, and values after changes over LAG rows, shape (m, j).
        self._picked = [Picked(sample_rows(rows, first), joints) for first in (0, LAG)]
        self.sample, self.changed = (one.values for one in self._picked)
        self.lowest, self.highest = np.full(joints, np.inf), np.full(joints, -np.inf)  # range, shape (j,)
        self.jump = np.zeros(joints)  # largest change between neighbouring rows, shape (j,)
        self.zeroed = np.zeros(joints, np.bool_)  # true where a large jump begins or ends at zero, shape (j,)
        self._to_zero = to_zero

    def take(self, first: int, before: Float, piece: Float, lowest: Float, highest: Float) -> None:
        """Take the rows of a piece, given the row before it and its range."""
        self.lowest, self.highest = np.minimum(self.lowest, lowest), np.maximum(self.highest, highest)
        steps = np.empty_like(piece)
        steps[0] = piece[0] - before
        np.subtract(piece[1:], piece[:-1], out=steps[1:])
        jump = np.maximum(steps.max(axis=0), -steps.min(axis=0))
        self.jump = np.maximum(self.jump, jump)
        for joint in np.flatnonzero((jump > self._to_zero) & (lowest <= 0.0) & (highest >= 0.0)):
            large = np.flatnonzero(np.abs(steps[:, joint]) > self._to_zero)
            column = piece[large, joint]
            self.zeroed[joint] |= bool(((column == 0.0) | (column == steps[large, joint])).any())
        for picked in self._picked:
            picked.take(first, piece)


class Samples:
    """Pieces one after the other in arrays, channels of shape (n, j) in Fortran order."""

    _SMALLEST = 1024
    # Of what comes with the channels: nanoseconds of messages, names of joints; other clocks are floats.
    _TYPES: Mapping[str, type] = {"header_stamp": np.int64, "log_time": np.int64, "joint": object}

    def __init__(self, joints: int, channels: Iterable[str], expected: int, *, every: int = 1) -> None:
        """Make room for the number of samples expected, which grows with the pieces; keep one of so many."""
        self._room, self._every = max(expected // every, self._SMALLEST), every
        self.rows = self.count = 0  # samples so far, and those of them that are kept
        self.channels = {name: np.empty((self._room, joints), order="F") for name in channels}
        self._times: dict[str, NDArray[Any]] | None = None

    def add(self, times: Mapping[str, NDArray[Any]], channels: Mapping[str, Sequence[NDArray[Any]]]) -> None:
        """Append clocks, of which those stay that all pieces have, and a column per joint of each channel."""
        if self._times is None:
            self._times = {name: np.empty(self._room, self._TYPES.get(name, np.float64)) for name in times}
        count = len(next(iter(times.values())))
        kept = slice(-self.rows % self._every, None, self._every)
        rows = slice(self.count, self.count + len(range(count)[kept]))
        if rows.stop > self._room:
            self.resize(max(rows.stop, 2 * rows.start))
        self.rows, self.count = self.rows + count, rows.stop
        for name, array in self.channels.items():
            for joint, column in enumerate(channels[name]):
                array[rows, joint] = column[kept]
        self._times = {name: array for name, array in self._times.items() if name in times}
        for name, array in self._times.items():
            array[rows] = times[name][kept]

    def resize(self, rows: int) -> None:
        """Move everything, one array at a time; memory that was never written to costs nothing."""
        for arrays in (self.channels, self._times or {}) if rows != self._room else ():
            for name, old in arrays.items():
                arrays[name] = np.empty((rows, *old.shape[1:]), old.dtype, order="F")
                arrays[name][: self.count] = old[: self.count]
        self._room = rows

    @property
    def times(self) -> dict[str, NDArray[Any]]:
        """The clocks that all pieces have."""
        return {name: array[: self.count] for name, array in (self._times or {}).items()}


@dataclass(eq=False, kw_only=True, slots=True)
class Recording:
    """What a reader returns: names and units translated, faults not yet looked for; the receiver may work in place."""

    t: Float  # time since an origin of the reader's choice, shape (n,); any order, repeats allowed [s]
    channels: dict[str, Float]  # channel -> array of shape (n, j), Fortran order, NaN where nothing was recorded
    joint_names: tuple[str, ...]
    path: str = ""  # of the file, as the user gave it; empty until it was read
    clock: str = "column"  # or "robot_time", "header_stamp", "log_time"
    start_s: float | None = None  # Unix time of t = 0, or None when the clock does not say [s]
    origin_s: float = 0.0  # reading of the clock at t = 0 [s]
    guessed_unit: str = ""  # of the clock where neither its name nor its size says it
    first_s: float | None = None  # time of the log's first sample on the clock of t where only a part was read [s]
    robot: str = "unknown"  # by joint names or message types
    serial: str = ""  # number of the arm as the file states it
    topic: str | None = None  # read
    mapping: Mapping[str, str] = field(default_factory=dict)  # channel -> name in the file, with {i}
    torque_unit: str = ""  # of a torque that was converted; empty where its name decides
    clock_windows: int = 0  # windows of time on which the clock was checked against the motion
    findings: tuple[Finding, ...] = ()  # what the reader itself noticed (a truncated file, a topic without content)
    blocks: Blocks | None = None  # how it is read in blocks; t and the channels are then empty, or means of the blocks

    def with_findings(self, *findings: Finding | None) -> "Recording":
        """Return the recording with findings added."""
        return replace(self, findings=(*self.findings, *filter(None, findings)))

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(self.t) if self.blocks is None else self.blocks.rows

    def read(self, names: Collection[str] | None = None) -> Iterator[tuple[int, Float, dict[str, Float]]]:
        """Yield number of the first row, clock, and channels (all, or those asked for) of one piece after the other."""
        names, first = self.channels if names is None else names, 0
        if self.blocks is not None:
            for t, channels in ahead(self.blocks.read(names)):
                yield first, t, channels
                first += len(t)
            return
        for first in range(0, len(self.t), _PIECE):
            rows = slice(first, first + _PIECE)
            yield first, self.t[rows], {name: self.channels[name][rows] for name in names}

    def mended(self, mend: Callable[[Iterator[Block]], Iterator[Block]], rows: int | None = None) -> "Recording":
        """Return the recording with every block mended: one in memory at once and in place, else when it is read.

        ``mend`` goes from blocks to blocks, one for one or fewer at last; ``rows`` are left, if that changes.
        """
        ((t, channels),) = mend(iter([(self.t, self.channels)]))
        blocks = self.blocks
        if blocks is not None:
            own, rows = blocks.read, blocks.rows if rows is None else rows

            def read(names: Collection[str]) -> Iterator[Block]:
                found = ((t, {n: np.require(a, requirements="W") for n, a in some.items()}) for t, some in own(names))
                yield from (block for block in mend(found) if len(block[0]))

            blocks = blocks._replace(rows=rows, read=read, groups=(0,))
        return replace(self, t=t, channels=dict(channels), blocks=blocks)

    def changed(self, change: Callable[[Float, dict[str, Float]], Block]) -> "Recording":
        """Return the recording with a change made to every block on its own."""
        return self.mended(lambda blocks: (change(t, channels) for t, channels in blocks))

    def scaled(self, channel: str, factor: float | Float) -> "Recording":
        """Return the recording with a channel multiplied by a number, or by one for each joint."""

        def change(t: Float, channels: dict[str, Float]) -> Block:
            if channel in channels:
                channels[channel] *= factor
            return t, channels

        return self.changed(change)

    def without(self, marks: Marks) -> "Recording":
        """Return the recording without the rows that are marked."""
        rows = self.rows - marks.count

        def mend(blocks: Iterator[Block]) -> Iterator[Block]:
            first = left = 0
            for t, channels in blocks:
                lost = marks.of(first, len(t))
                first, left = first + len(t), left + len(t) - int(np.count_nonzero(lost))
                yield take_rows(t, channels, ~lost) if lost.any() else (t, channels)
                if left == rows:  # the rest is not even read
                    return

        return self.mended(mend, rows)

    def name_of(self, channel: str, joint: int) -> str:
        """Return how messages call a channel of a joint (0-based)."""
        return f"{channel} ({self.mapping.get(channel, channel)}) of {self.joint_names[joint]}"


def with_velocity(recording: Recording, step_s: float, *, asked: bool) -> Recording:
    """Return a recording in memory with the derivative of q as dq (Savitzky and Golay, 1964), unless dq was logged.

    A parabola is fitted to the samples within HALF_WINDOW_S of each, of a coarse position to more: to q and to t over
    the sample's number, so that an uneven clock does no harm. A quartic over twice that time has no more noise and cuts
    fast motion less; but its weights have both signs, so it stands where no samples are missing. There is no phase
    shift. Made anew, its finding is that of the last time: of a wild sample that is gone, noise is gone too.
    ``asked``: whether the user asked for it.
    """
    names = recording.mapping
    if "dq" in recording.channels and names.get("dq") != DERIVATIVE:
        return recording
    from scipy.signal import savgol_filter

    t, q = recording.t, recording.channels["q"]
    # One position within a turn may jump from one of its ends to the other.
    columns = [np.unwrap(column) if np.ptp(column) <= _TURN_RAD else column for column in q.T]

    def fitted(half_s: float, order: int = 2) -> tuple[int, Float, Float]:
        width = min(order * max(1, round(half_s / step_s)) + 1, (len(t) - 1) // 2 * 2 + 1)
        ts, *qs = (savgol_filter(x, width, order, deriv=1) if width > order else np.gradient(x) for x in (t, *columns))
        return width, ts, np.asfortranarray(np.divide(qs, ts).T)

    _, steps, rate = fitted(half_s := HALF_WINDOW_S)
    # Noise and resolution, from sixth differences without those of the clock; the slope's falls with width^1.5.
    sixth = (np.diff(x, 6) - v[3:-3] * np.diff(t, 6) for x, v in zip(columns, rate.T, strict=True))
    noise = max(float(np.abs(one).sum()) for one in sixth) / (MEAN_OF_SIXTH * len(t))
    enough_s = 0.5 * step_s * (np.sqrt(12.0) * noise / (NOISE_RAD_S * step_s)) ** (2.0 / 3.0)
    if enough_s > HALF_WINDOW_S:
        longest, _, smooth = fitted(LONGEST_HALF_WINDOW_S)
        lag = max(longest // 2, 1)
        jerk = np.sqrt(np.mean(np.diff(smooth[::lag], 2, axis=0) ** 2, axis=0).max()) / (lag * step_s) ** 2
        # Least variance plus squared bias, 1.5 noise^2 step / half^3 + (jerk half^2 / 10)^2.
        best_s = (112.5 * noise**2 * step_s / max(jerk, 1e-9) ** 2) ** (1.0 / 7.0)
        _, steps, rate = fitted(half_s := min(enough_s, max(best_s, HALF_WINDOW_S), LONGEST_HALF_WINDOW_S))
    width, longer, better = fitted(half_s, 4)
    np.copyto(rate, better, where=(np.abs(longer - steps) < _UNEVEN * steps)[:, None])
    message = f"dq is the derivative of q ({names.get('q', 'q')}), by a polynomial through {width} samples"
    if recording.guessed_unit:
        message += f" of a clock read in {recording.guessed_unit}"
    if not asked:
        message = f"no velocity was found: {message}; if there is one by another name, use --map dq=NAME"
    finding = Finding("velocity_derived", message)
    findings = tuple(finding if one.code == finding.code else one for one in recording.findings)
    findings = findings if finding in findings else (*findings, finding)
    channels, mapping = recording.channels | {"dq": rate}, {**names, "dq": DERIVATIVE}
    return replace(recording, channels=channels, mapping=mapping, findings=findings)


def take_rows(t: Float, channels: dict[str, Float], rows: NDArray[Any]) -> Block:
    """Return the rows of a mask or in an order; works in place, one column at a time, without a second copy."""
    count = int(np.count_nonzero(rows)) if rows.dtype == np.bool_ else len(rows)
    for array in channels.values():
        for column in array.T:
            column[:count] = column[rows]
    return t[rows], {name: array[:count] for name, array in channels.items()}
