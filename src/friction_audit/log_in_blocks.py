"""LogInBlocks: a log of any length, of which only means and a block of samples are in memory."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_audit.joint_log import Float, Int, JointLog, LogPart
from friction_audit.parallel import ahead

# A longer log is judged by means of stretches that are spread evenly over it: an hour at 50 Hz, in pieces of 20 s.
MOST_MEANS, STRETCH = 180_000, 1 << 10
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

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return self.clock[0]

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample. [s]"""
        return self.clock[1]

    @property
    def rate_hz(self) -> float:
        """Sampling rate, from the median time step. [Hz]"""
        return 1.0 / self.clock[2]

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
        for name, piece in (("t", t[:, None]), *channels.items()):
            begun = np.concatenate([self._rest[name], piece[:first]])  # of the mean that was begun
            if own.any():
                found = np.concatenate([block_means(begun, size), block_means(piece[first:], size)])[: len(own)]
                (self.t if name == "t" else self.channels[name])[places] = found if own.all() else found[own]
            self._rest[name] = begun if left > len(t) else piece[len(t) - left :].copy()
