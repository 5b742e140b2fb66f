"""The clock of a recording: order of the stamps, stamps of batches, steps that are missing or uneven, a part of it."""

from bisect import bisect
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.clocks import LONGEST_BACKWARDS_S
from friction_audit.io.recording import Block, Marks, Picked, Recording, Thinned, WholeLogError, sample_rows, take_rows
from friction_audit.joint_log import Finding, Float, check_window, step_places

Window = tuple[float | None, float | None]  # start and end of the part asked for, None for those of the log [s]

_MOST_BACKWARDS = 0.01
_YEARS_S = 1e8
_SHOWN = 5
_JUMP_RAD = 0.02  # usual change of q from row to row that is none of one joint


class Clock:
    """What a pass over the stamps of a recording finds."""

    def __init__(self, recording: Recording) -> None:
        self.rows = rows = recording.rows
        self.increases, self.backwards, self.places = False, 0, list[int]()
        self.late_s, self.latest, self.repeated = 0.0, 0, Marks(rows)
        reach, every = min(_LONGEST_BATCH, rows - 1), max(rows // _MOST_PLACES, 1)
        near, far = step_places(rows), np.arange(reach, rows, every)
        picked = [Picked(one) for one in (near, near + 1, far - reach, far, sample_rows(rows))]
        every_step, self.first_s, self.last_s = Thinned(), np.nan, np.nan
        last = latest = -np.inf
        for first, t, _ in recording.read(()):
            if not np.isfinite(t).all():
                return
            self.first_s = float(t[0]) if first == 0 else self.first_s
            for one in picked:
                one.take(first, t)
            steps = np.diff(t, prepend=last)
            every_step.take(steps if first else steps[1:])
            if steps.min() <= 0.0:
                back = np.flatnonzero(steps < 0.0)
                self.backwards += len(back)
                self.places += (first + 1 + back[: _SHOWN - len(self.places)]).tolist()
                late_s = np.maximum.accumulate(np.maximum(t, latest)) - t
                if late_s.max() > self.late_s:
                    self.late_s, self.latest = float(late_s.max()), first + int(late_s.argmax())
                self.repeated.add(first, steps == 0.0)
            last, latest = float(t[-1]), max(latest, float(t.max()))
        self.last_s, self.increases = last, not self.backwards and not self.repeated.count
        before, after, begin, end, self.sample = (one.values for one in picked)  # the last one of the rows of a Column
        self.step_s = float(np.median(after - before))  # as that of a JointLog
        self.median = float(np.median(every_step.values))
        # The median of mean steps over more than a batch: holes do not count.
        self.rough = float(np.median(end - begin)) / reach


def leave_out_undated(recording: Recording, clock: Clock) -> Recording:
    """Leave out the rows, if they are few, whose stamps lie years from those of the others: most often 0, for none."""
    middle, marks = float(np.median(clock.sample)), Marks(recording.rows)
    if max(abs(clock.first_s - middle), abs(clock.last_s - middle), clock.late_s) > _YEARS_S:
        for first, t, _ in recording.read(()):
            marks.add(first, np.abs(t - middle) > _YEARS_S)
    if not 0 < marks.count <= max(_MOST_BACKWARDS * (recording.rows - 1), 1.0):
        return recording
    text = f"{marks.count} of {recording.rows} rows carry a time stamp years from that of the others; they are left out"
    finding = Finding("non_finite", text, amount=float(marks.count), damaged=True)
    return recording.without(marks).with_findings(finding)


def sort_rows(recording: Recording, clock: Clock) -> Recording:
    """Return the recording with its rows in order of time; InputError if time stands still or runs backwards by far."""
    if clock.increases:
        return recording
    name, rows, backwards = recording.mapping.get("t", recording.clock), clock.rows, clock.backwards
    if clock.repeated.count == rows - 1:
        raise InputError(
            f"{recording.path}: time ({name}) is the same in all {rows} rows; expected strictly increasing stamps; "
            "name another clock with --map t=<column>, or another topic"
        )
    is_few = backwards <= max(_MOST_BACKWARDS * (rows - 1), 1.0)
    if clock.late_s > LONGEST_BACKWARDS_S or not is_few:
        advice = "bring the rows into order"
        if is_few:
            starts = ", ".join(map(str, clock.places))
            advice = (
                f"these look like {backwards + 1} recordings in one file: cut it before row {starts}"
                f"{'...' if backwards > _SHOWN else ''} and read each part"
            )
        raise InputError(
            f"{recording.path}: time ({name}) goes back at {backwards} of {rows - 1} rows, by up to "
            f"{clock.late_s:.4g} s at row {clock.latest + 1}; expected increasing stamps; {advice}, or name another "
            "clock with --map t=<column>"
        )
    if not backwards:
        return recording
    text = f"{backwards} rows of {recording.path} are older than the row before them; they are sorted"
    finding = Finding("unordered", text, amount=float(backwards))
    return recording.mended(partial(_sorted, late_s=clock.late_s)).with_findings(finding)


def _sorted(blocks: Iterator[Block], late_s: float) -> Iterator[Block]:
    """Sort rows of which none comes later than so after one that is older; those that may not be in place wait."""
    following, t, channels = next(blocks, None), np.empty(0), dict[str, Float]()
    while following is not None:
        waiting, (t, channels) = (t, channels), following
        following = next(blocks, None)
        if len(waiting[0]):
            t = np.append(waiting[0], t)
            channels = {name: np.concatenate([waiting[1][name], array]) for name, array in channels.items()}
        t, channels = take_rows(t, channels, np.argsort(t, kind="stable"))
        ready = len(t) if following is None else int(np.searchsorted(t, t[-1] - late_s))
        yield t[:ready], {name: array[:ready] for name, array in channels.items()}
        t, channels = t[ready:], {name: array[ready:] for name, array in channels.items()}


def drop_repeats(recording: Recording, clock: Clock) -> Recording:
    """Leave out rows with the stamp of the one before; spread the stamps of a coarse clock, where such rows differ.

    InputError where a table has a row for each joint and time.
    """
    repeats = clock.repeated.count
    if not repeats:
        return recording
    if len(recording.joint_names) == 1 and 2 * repeats >= clock.rows - 1:
        _, t, channels = next(iter(recording.read(("q",))))
        jumps, same = np.abs(np.diff(channels["q"][:, 0])), np.diff(t) == 0.0
        within, over = (float(np.nanmedian(jumps[rows])) for rows in (same, ~same))
        if min(within, over) > _JUMP_RAD:
            raise InputError(
                f"{recording.path}: {repeats} of {clock.rows} rows carry the stamp of the row before them, and q jumps "
                f"by {within:.3g} between these: they look like rows of several joints; expected one column per joint, "
                "or the joint of each row in a column called 'joint'; rename it"
            )
    if repeats >= _LEAST_SHARE * (clock.rows - 1) and _differ(recording):
        if clock.rough <= 0.0:
            raise InputError(
                f"{recording.path}: time ({recording.mapping.get('t', recording.clock)}) takes {clock.rows - repeats} "
                f"values in {clock.rows} rows, too few to show when each was sampled; expected a stamp per sample; "
                "write it with more digits, or name another clock with --map t=<column>"
            )
        return _spread(recording, clock.rough)
    text = (
        f"{repeats} of {clock.rows} rows ({repeats / clock.rows:.1%}) carry the stamp of the row before them; "
        "the first of each stamp is kept"
    )
    return recording.without(clock.repeated).with_findings(Finding("duplicate_stamps", text, amount=float(repeats)))


def _differ(recording: Recording) -> bool:
    """Return True if the state changes within a stamp at least half as often as between stamps: no copies of rows."""
    changes, steps = np.zeros(2), np.zeros(2)  # between stamps and within
    for _, t, channels in recording.read():
        state = np.column_stack([*channels.values()])
        within = (np.diff(t) == 0.0).astype(int)
        steps += np.bincount(within, minlength=2)
        changes += np.bincount(within, np.any(np.diff(state, axis=0) != 0.0, axis=1), minlength=2)
    between, inside = changes / np.maximum(steps, 1.0)
    return bool(inside >= 0.5 * between > 0.0)


_SHORT = 0.5  # steps below so much of a period lie within a batch
_LEAST_SHARE = 0.25  # of short steps, from which on stamps are those of batches: half in pairs, more in longer ones
_LONGEST_BATCH = 64  # samples over which the rate is even again; longer batches are not seen
_MOST_PLACES = 1 << 16


def spread_batches(recording: Recording, steps: "Steps") -> Recording:
    """Put the samples of a batch a period apart, the last one where it is; WholeLogError if they are read in blocks."""
    # Every step counts: of every second one, a log that comes in pairs would show only short ones or only long ones.
    if steps.short < _LEAST_SHARE * steps.count:
        return recording
    return _spread(recording, steps.rough)


def _spread(recording: Recording, rough_s: float) -> Recording:
    if recording.blocks is not None:
        raise WholeLogError
    t = recording.t
    ends = np.append(np.flatnonzero(~(np.diff(t) < _SHORT * rough_s)), len(t) - 1)
    # Mean steps over whole batches: a part of one would make the period too short or too long.
    reach = min(max(round(_LONGEST_BATCH * len(ends) / len(t)), 1), len(ends) - 1)
    period = float(np.median((t[ends[reach:]] - t[ends[:-reach]]) / (ends[reach:] - ends[:-reach])))
    size = np.diff(ends, prepend=-1)
    since = np.diff(t[ends], prepend=t[ends[0]] - size[0] * period)
    # A backlog may hold more samples than there was time for since the last batch: these share that time.
    apart = np.minimum(period, since / size)
    before = np.repeat(ends, size) - np.arange(len(t))
    is_coarse = np.count_nonzero(np.diff(t) == 0.0) >= _LEAST_SHARE * (len(t) - 1)
    how = "share a stamp, for the clock is coarse or rounded" if is_coarse else "carry times of arrival"
    message = (
        f"samples arrive in {len(ends)} batches of {len(t) / len(ends):.1f} on average and {how}; "
        f"those of a batch are put {1e3 * period:.3g} ms apart; record the sensor's own stamps if there are any"
    )
    finding = Finding("batched_stamps", message, amount=float(len(ends)))
    return replace(recording, t=np.repeat(t[ends], size) - before * np.repeat(apart, size)).with_findings(finding)


GAP_S = 0.05
DROPPED_STEPS = 1.5
_GAP_STEPS, _HOLE_STEPS = 5.0, 3.0  # a gap is reported on its own; a smaller hole interrupts what is read of a motion
_JITTER_SHARE = 0.1
_LOW_RATE_HZ = 100.0
_TIMER = 0.95  # a timer of 100 Hz is a little off


def gap_threshold_s(median_step_s: float) -> float:
    """Return the step from which on a gap in the recording is reported on its own. [s]"""
    return max(_GAP_STEPS * median_step_s, GAP_S)


class Steps:
    """What a pass finds of the steps of a clock, in order of time."""

    def __init__(self, clock: Clock) -> None:
        self.median, self.rough, self.threshold_s = clock.median, clock.rough, gap_threshold_s(clock.median)
        self.count, self.long, self.dropped, self.gaps, self.longest, self.short = 0, 0, 0.0, 0, 0.0, 0
        self.holes: list[tuple[int, float, float]] = []  # row before, its stamp and that of the next one
        self._off, self._square = 0.0, 0.0  # of the steps that are not long, less the median

    def take(self, first: int, before: float, t: Float) -> None:
        """Add the steps that end in a piece, given the stamp before it."""
        steps = np.diff(t, prepend=before) if first else np.diff(t)
        long = steps[steps > DROPPED_STEPS * self.median]
        gaps = long[long > self.threshold_s]
        # By sums around the median instead of a masked copy of the steps.
        off, off_long = steps - self.median, long - self.median
        self.count, self.long, self.gaps = self.count + len(steps), self.long + len(long), self.gaps + len(gaps)
        self.dropped += float(np.maximum(np.round(long / self.median) - 1.0, 1.0).sum())
        self.longest = max(self.longest, float(gaps.max(initial=0.0)))
        self._off += float(off.sum() - off_long.sum())
        # No product of BLAS, whose threads would wait for each other.
        self._square += float(np.einsum("i,i", off, off) - np.einsum("i,i", off_long, off_long))
        self.short += int(np.count_nonzero(steps < _SHORT * self.rough))
        if len(long):
            ends = np.flatnonzero(steps > max(_HOLE_STEPS * self.median, GAP_S)) + len(t) - len(steps)
            self.holes += [(first + end - 1, t[end - 1] if end else before, t[end]) for end in ends.tolist()]

    def findings(self) -> Iterator[Finding]:
        """Yield what is to be noticed."""
        median = self.median
        if self.long:
            text = f"{self.dropped:.0f} samples dropped at {self.long} places (median step {median * 1e3:.3g} ms)"
            yield Finding("dropped_samples", text, amount=self.dropped)
        if self.gaps:
            text = f"gaps longer than {self.threshold_s:.3g} s: {self.gaps}, the longest {self.longest:.3g} s"
            yield Finding("gap", text, amount=float(self.gaps))
        even = self.count - self.long
        deviation = float(np.sqrt(max(self._square / even - (self._off / even) ** 2, 0.0)))
        if deviation > _JITTER_SHARE * median:
            text = (
                f"time step: standard deviation {deviation * 1e3:.3g} ms, median {median * 1e3:.3g} ms (without gaps); "
                "integrals use the logged time stamps"
            )
            yield Finding("jitter", text, amount=deviation)
        if (rate := 1.0 / median) < _TIMER * _LOW_RATE_HZ:
            text = (
                f"{rate:.3g} Hz is a low sampling rate: reversals and inertial torques are poorly resolved; record at "
                f"{_LOW_RATE_HZ:.0f} Hz or more"
            )
            yield Finding("low_rate", text, amount=rate)


def take_window(recording: Recording, clock: Clock, window: Window, origin_s: float) -> Recording:
    """Return the part that was asked for, on a clock that is 0 at the first sample of the whole log."""
    counts = [0, 0]
    for _, t, _ in recording.read(()):
        for k, limit in enumerate(window):
            counts[k] += int(np.searchsorted(t - origin_s, (-np.inf, np.inf)[k] if limit is None else limit))
    part = check_window(counts[0], counts[1], *window, clock.last_s - origin_s, recording.path)

    def mend(blocks: Iterator[Block]) -> Iterator[Block]:
        first = 0
        for t, channels in blocks:
            own = slice(max(part.start - first, 0), max(part.stop - first, 0))
            yield t[own] - origin_s, {name: array[own] for name, array in channels.items()}
            first += len(t)
            if first >= part.stop:
                return

    start_s = None if recording.start_s is None else recording.start_s + origin_s
    return replace(recording.mended(mend, part.stop - part.start), start_s=start_s)


def leave_out_far(recording: Recording, start_s: float, stop_s: float) -> Recording:
    """Return the rows of a recording that is read in blocks from a time to another, since its first sample."""
    blocks, origin_s, kept = recording.blocks, np.inf, list[int]()
    assert blocks is not None
    for _, t, _ in recording.read(()):
        origin_s = min(origin_s, float(np.fmin.reduce(t)))
    marks = Marks(recording.rows)
    for first, t, _ in recording.read(()):
        near = (t - origin_s >= start_s) & (t - origin_s < stop_s)
        marks.add(first, ~near)
        kept += (first + np.flatnonzero(near)[[0, -1]]).tolist() if near.any() else []
    if not kept:  # the part is refused later, with the duration of the log
        return recording
    if len(blocks.groups) > 1:
        skipped = blocks.groups[group := bisect(blocks.groups, kept[0]) - 1]
        read = partial(blocks.read, group=group)
        recording = replace(recording, blocks=blocks._replace(rows=blocks.rows - skipped, read=read, groups=(0,)))
        rest, marks = marks.of(skipped, blocks.rows - skipped), Marks(blocks.rows - skipped)
        marks.add(0, rest)
    return replace(recording.without(marks), first_s=origin_s)
