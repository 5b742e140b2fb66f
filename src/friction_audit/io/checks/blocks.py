"""A recording that is examined block by block, as long as it has no fault, and the means of its blocks."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.checks.clock import DROPPED_STEPS, GAP_S, LEAST_SHARE, SHORT, StepSums, places_of_batches
from friction_audit.io.checks.motion import LARGEST_Q_RAD, TRAVELLED, check_motion, mend_units
from friction_audit.io.checks.torque import check_torque, drop_stale_samples
from friction_audit.io.checks.values import ABSURD, LAG, MOST_SAMPLES, scale_of, usual_change
from friction_audit.io.recording import Blocks, Recording, WholeLogError
from friction_audit.joint_log import MINIMUM_SAMPLES, Float, step_places
from friction_audit.log_in_blocks import block_means, samples_per_mean
from friction_audit.parallel import ahead

__all__ = ["WholeLogError", "examine_in_blocks"]

# A longer log is judged by means of stretches that are spread evenly over it: an hour at 50 Hz, in pieces of 20 s.
MOST_MEANS, STRETCH = 1 << 18, 1 << 10
_GAP_STEPS = 3.0  # smaller steps matter to nothing


def examine_in_blocks(recording: Recording, blocks: Blocks, path: str) -> Recording:
    """Return the recording with the means of its blocks, and what was noticed about its clock.

    Raises:
        WholeLogError: If it has a fault, or may have one.
    """
    try:
        last_s, median, rough = _look_at_clock(blocks)
        survey = _Survey(recording, blocks.rows, median, rough)
        for t, channels in ahead(blocks.read(recording.channels)):
            survey.take(t, channels)
        means = survey.means(recording)
        found = _judge(survey, means, path)
    except InputError as error:
        raise WholeLogError from error
    gaps, numbers = np.array(survey.gaps).reshape(-1, 3), survey.numbers()
    clock = (blocks.rows, last_s, median)
    known = replace(blocks, clock=clock, gaps=gaps, mean_of=survey.mean_of, numbers=numbers)
    means = replace(means, blocks=known, clock_windows=found.clock_windows, findings=recording.findings)
    return means.with_findings(*survey.steps.findings())


class _Picked:
    """Values at some places of a recording, gathered block by block."""

    def __init__(self, places: NDArray[np.int64], *shape: int) -> None:
        self.places, self.values = places, np.empty((len(places), *shape), order="F")

    def take(self, first: int, block: Float) -> None:
        """Take those of a block whose first row has this number."""
        start, stop = np.searchsorted(self.places, (first, first + len(block)))
        self.values[start:stop] = block[self.places[start:stop] - first]


def _look_at_clock(blocks: Blocks) -> tuple[float, float, float]:
    """Return the last stamp, the median step and the rough step of a clock that increases strictly."""
    rows = blocks.rows
    if rows < MINIMUM_SAMPLES:
        raise WholeLogError
    places, (reach, every) = step_places(rows), places_of_batches(rows)
    far = np.arange(reach, rows, every)
    picked = [_Picked(one) for one in (places, places + 1, far - reach, far)]
    row, last = 0, -np.inf
    for t, _ in ahead(blocks.read(())):
        if not (np.isfinite(t).all() and t[0] > last and np.all(t[1:] > t[:-1])):
            raise WholeLogError
        for one in picked:
            one.take(row, t)
        row, last = row + len(t), float(t[-1])
    before, after, begin, end = (one.values for one in picked)
    return last, float(np.median(after - before)), float(np.median(end - begin)) / reach


class _Survey:
    """What a first pass over a recording finds."""

    def __init__(self, recording: Recording, rows: int, median: float, rough: float) -> None:
        every = max(rows // MOST_SAMPLES, 1)
        joints, names = len(recording.joint_names), list(recording.channels)
        usual, late = np.arange(0, rows, every), np.arange(LAG, rows, every)
        self.mean_of = samples_per_mean(median, rows)
        self.steps, self.short = StepSums(median), 0
        self.gaps: list[tuple[int, float, float]] = []
        self.sample_t = _Picked(usual)
        self.sample = {name: _Picked(usual, joints) for name in names}
        self.change = {name: (_Picked(late - LAG, joints), _Picked(late, joints)) for name in names}
        self.lowest = {name: np.full(joints, np.inf) for name in names}
        self.highest = {name: np.full(joints, -np.inf) for name in names}
        self.jump = {name: np.zeros(joints) for name in names}
        self._recording, self._rough, self._row = recording, rough, 0
        self._all = rows // self.mean_of
        self._every = -(-self._all // MOST_MEANS)  # of so many stretches one is kept
        kept = len(self.numbers())
        self._means = {"t": np.empty((kept, 1))} | {name: np.empty((kept, joints), order="F") for name in names}
        self._kept = 0
        self._rest: dict[str, Float] = {}
        self._last: dict[str, Float] = {}  # the row before the block

    def take(self, t: Float, channels: dict[str, Float]) -> None:
        """Look at a block.

        Raises:
            WholeLogError: If it has a fault that shows in the rows themselves.
        """
        old = self._last or {name: new[:1] for name, new in {"t": t, **channels}.items()}
        lost = self._take_clock(t, old["t"])
        self.sample_t.take(self._row, t)
        for name, new in channels.items():
            for joint, column in enumerate(new.T):
                low, high, steps = column.min(), column.max(), np.diff(column, prepend=old[name][:, joint])
                if not (low > -ABSURD and high < ABSURD):  # nor is NaN
                    raise WholeLogError
                steps[lost] = 0.0
                self.lowest[name][joint] = min(self.lowest[name][joint], low)
                self.highest[name][joint] = max(self.highest[name][joint], high)
                self.jump[name][joint] = max(self.jump[name][joint], steps.max(), -steps.min())
            for picked in (self.sample[name], *self.change[name]):
                picked.take(self._row, new)
        pair = {name: np.concatenate([old[name], new[:1]]) for name, new in {"t": t, **channels}.items()}
        for near in ({"t": t, **channels}, pair) if self._last else ({"t": t, **channels},):
            if drop_stale_samples(replace(self._recording, t=near.pop("t"), channels=near)).findings:
                raise WholeLogError
        self._last = {"t": t[-1:], **{name: new[-1:].copy() for name, new in channels.items()}}
        self._add_means({"t": t[:, None], **channels})
        self._row += len(t)

    def _take_clock(self, t: Float, before: Float) -> NDArray[np.int64]:
        """Return the rows before which samples were lost: a joint is elsewhere after them."""
        steps = np.diff(t, prepend=before)
        self.steps.take(steps if self._row else steps[1:])
        self.short += int(np.count_nonzero(steps[0 if self._row else 1 :] < SHORT * self._rough))
        for row in np.flatnonzero(steps > max(_GAP_STEPS * self.steps.median, GAP_S)).tolist():
            self.gaps.append((self._row + row - 1, before[0] if row == 0 else t[row - 1], t[row]))
        return np.flatnonzero(steps > DROPPED_STEPS * self.steps.median)

    def _add_means(self, arrays: dict[str, Float]) -> None:
        waiting, size = self._row % self.mean_of, self.mean_of
        done, count = self._row // size, (waiting + len(arrays["t"])) // size
        kept = (np.arange(done, done + count) // STRETCH) % self._every == 0
        places = slice(self._kept, self._kept + int(np.count_nonzero(kept)))
        self._kept = places.stop
        head = size - waiting if waiting else 0  # rows that complete a mean
        for name, array in arrays.items():
            rest = self._rest.get(name, array[:0])
            if not count:
                self._rest[name] = np.concatenate([rest, array])
                continue
            first = np.concatenate([rest, array[:head]])
            for joint in range(array.shape[1]):
                means = block_means(first[:, joint], size), block_means(array[head:, joint], size)
                self._means[name][places, joint] = np.concatenate(means)[kept]
            self._rest[name] = array[len(array) - (waiting + len(array)) % size :].copy()

    def numbers(self) -> NDArray[np.int64]:
        """Return the number of each mean that was kept among all."""
        numbers = np.arange(self._all)
        return np.asarray(numbers[(numbers // STRETCH) % self._every == 0])

    def means(self, recording: Recording) -> Recording:
        """Return the recording of the means."""
        channels = {**self._means}
        return replace(recording, t=channels.pop("t")[:, 0], channels=channels)


def _judge(survey: _Survey, means: Recording, path: str) -> Recording:
    """Return the means as their checks leave them.

    Raises:
        WholeLogError: If something was found.
        InputError: If the recording is refused.
    """
    if survey.short >= LEAST_SHARE * survey.steps.count:
        raise WholeLogError
    for name, picked in survey.sample.items():
        before, after = (one.values for one in survey.change[name])
        for joint, jump in enumerate(survey.jump[name]):
            if jump > scale_of(name, picked.values[:, joint], usual_change((after - before)[:, joint])):
                raise WholeLogError
    # A velocity that never changes is dead, or of a joint that turns without end, which may be in degrees.
    moved = survey.highest["q"] - survey.lowest["q"] > TRAVELLED
    still = survey.highest["dq"] == survey.lowest["dq"]
    largest = np.maximum(survey.highest["q"], -survey.lowest["q"]).max()
    if (moved & still).any() or largest > LARGEST_Q_RAD:
        raise WholeLogError
    sample = {name: picked.values for name, picked in survey.sample.items()}
    found = check_torque(replace(means, t=survey.sample_t.values, channels=sample, findings=()))
    judged = check_motion(mend_units(replace(means, findings=()), path), path, scaled=False)
    if found.findings or judged.findings:
        raise WholeLogError
    return judged
