"""The faults of a recording: each is noticed, named with its amount, and handled or refused.

A recording is looked through in passes, piece by piece: one over the clock, one over all columns. The checks judge by
what these have found, in the order of ``examine``. Where one mends something, the next ones need new passes, over the
mended pieces; a sound log takes no more than two.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.checks import motion
from friction_audit.io.checks.clock import (
    Clock,
    Steps,
    drop_repeats,
    leave_out_undated,
    sort_rows,
    spread_batches,
    take_window,
)
from friction_audit.io.checks.held import Stale, Stretches, drop_stale_samples, interpolate_held, noisy_velocity
from friction_audit.io.checks.values import Missing, check_torque, find_frozen, leave_out_columns, leave_out_rows
from friction_audit.io.checks.wild import TO_ZERO, leave_out_wild
from friction_audit.io.recording import Column, Recording, WholeLogError, with_velocity
from friction_audit.joint_log import DERIVATIVE, MINIMUM_SAMPLES, Float, Means

if TYPE_CHECKING:
    from friction_audit.io.readers.reader import ReadOptions

Take = Callable[[int, Float, dict[str, Float]], None]
Listen = Callable[[Recording], Take | None]
"""Given what is known of a recording at its first block: takes every block while it is checked, or is None."""


class _Look:
    """What passes over a recording find; of one with a fault that hides others, that fault alone."""

    def __init__(self, recording: Recording, listen: Listen) -> None:
        samples = recording.rows
        if samples < MINIMUM_SAMPLES:
            said = "; ".join(finding.message for finding in recording.findings)
            raise InputError(
                f"{recording.path}: {samples} sample{'' if samples == 1 else 's'}; at least {MINIMUM_SAMPLES} are "
                f"needed for a joint log{f' ({said})' if said else ''}; record the arm while it moves"
            )
        self.recording, self._listen, self.clock = recording, listen, (clock := Clock(recording))
        self.listener: Take | None = None
        joints, names = len(recording.joint_names), recording.channels
        if recording.blocks is not None and "dq" not in names:
            raise WholeLogError  # it is made from q at once
        self.missing = Missing(recording)
        self.columns = {name: Column(samples, joints, TO_ZERO.get(name, np.inf)) for name in names}
        self.stale, self.near = Stale(recording), Stretches(recording)
        self._before: dict[str, Float] = {}
        if clock.increases:
            self.steps, self._motion = Steps(clock), motion.Motion(clock, joints)
            self.means = None if recording.blocks is None else Means(clock.step_s, samples, names, joints)
        with np.errstate(over="ignore", invalid="ignore"):
            for first, t, channels in recording.read():
                ranges = self.missing.take(first, t, channels)
                if clock.increases and not self.missing.marks.count:
                    self._take(first, t, channels, ranges)

    def after(self, recording: Recording) -> "_Look":
        """Return what is known after a check: all, unless it has mended something."""
        old = self.recording
        if recording.blocks is old.blocks and recording.t is old.t and recording.channels is old.channels:
            self.recording = recording
            return self
        return _Look(recording, self._listen)

    def _take(self, first: int, t: Float, channels: dict[str, Float], ranges: dict[str, tuple[Float, Float]]) -> None:
        before = self._before or {"t": t[:1], **{name: piece[0] for name, piece in channels.items()}}
        last_s = before["t"][0]
        self.steps.take(first, last_s, t)
        for name, piece in channels.items():
            self.columns[name].take(first, before[name], piece, *ranges[name])
        if "dq" in channels:
            self._motion.take(first, t, (last_s, before["dq"]), channels["q"], channels["dq"])
            self.stale.take(first, t, before, channels)
            self.near.take(first, channels)
        self._before = {"t": t[-1:].copy()} | {name: piece[-1].copy() for name, piece in channels.items()}
        if self.means is None:
            return
        self.means.take(t, channels)
        if first == 0:
            self.listener = self._listen(self.concluded())
        if self.stale.marks.count:  # they will be left out, and all blocks be looked at anew
            self.listener = None
        if self.listener is not None:
            self.listener(first, t - self.clock.first_s, channels)

    def concluded(self) -> Recording:
        """Return the recording in blocks with means in place of its samples, on a clock that begins at 0."""
        blocks, clock, means, first_s = self.recording.blocks, self.clock, self.means, self.clock.first_s
        assert blocks is not None
        assert means is not None
        read, (t, channels) = blocks.read, means.found
        found = {
            "clock": (clock.rows, clock.last_s - first_s, clock.step_s),
            "gaps": np.array(self.steps.holes).reshape(-1, 3) - (0.0, first_s, first_s),
            "mean_of": means.of,
            "numbers": means.numbers[: len(t)],
            "listener": self.listener,
        }
        own = read if first_s == 0.0 else lambda names: ((t - first_s, channels) for t, channels in read(names))
        blocks = blocks._replace(read=own, found=found)
        return replace(self.recording, t=t - first_s, channels=channels, blocks=blocks, first_s=first_s)

    @cached_property
    def ratios(self) -> motion.MotionRatio:
        """Return the change of q over the integral of dq."""
        return self._motion.ratios(self.steps.holes)


def examine(recording: Recording, options: "ReadOptions", listen: Listen = lambda _: None) -> Recording:
    """Notice, handle or refuse the faults of a recording; one in memory is worked on in place.

    ``listen`` is asked at the first block of every pass over all columns of a recording in blocks; what took the blocks
    as they are at last is in these. WholeLogError if it is read in blocks and cannot be.
    """
    recording, time_scale = replace(recording, robot=options.robot or recording.robot), options.time_scale
    as_read = recording.rows
    if time_scale != 1.0:
        recording = recording.changed(lambda t, channels: (t * time_scale, channels))
    look = _Look(recording, (lambda _: None) if options.has_window else listen)
    look = look.after(leave_out_columns(look.recording, look.missing))
    look = look.after(leave_out_rows(look.recording, look.missing))
    look = look.after(leave_out_undated(look.recording, look.clock))
    look = look.after(sort_rows(look.recording, look.clock))
    look = look.after(drop_repeats(look.recording, look.clock))
    look = look.after(spread_batches(look.recording, look.steps))
    read_s = None if recording.first_s is None else recording.first_s * time_scale  # of the whole log's first sample
    first_s = look.clock.first_s if read_s is None else read_s
    numbered = read_s is None and look.recording.rows == as_read
    step_s = look.clock.step_s
    look = look.after(motion.join_turns(look.recording, look.columns))
    asked = look.recording.mapping.get("dq") == DERIVATIVE
    look = look.after(with_velocity(look.recording, step_s, asked=asked))
    look = look.after(leave_out_wild(look.recording, look.columns, step_s, first_s=first_s, numbered=numbered))
    look = look.after(with_velocity(look.recording, step_s, asked=asked))  # anew from what is left, here and below
    look = look.after(motion.refuse_dead_velocity(look.recording, look.columns, look.clock))
    look = look.after(motion.turn_to_radians(look.recording, look.columns, look.ratios.common))
    look = look.after(motion.mend_unit(look.recording, look.ratios.common, look.clock.step_s))
    look = look.after(look.recording.with_findings(*look.steps.findings()))
    look = look.after(drop_stale_samples(look.recording, look.stale, look.columns))
    look = look.after(with_velocity(look.recording, look.clock.step_s, asked=asked))
    look = look.after(interpolate_held(look.recording, look.near, look.clock.step_s))
    look = look.after(noisy_velocity(look.recording, look.near))
    look = look.after(check_torque(look.recording, look.columns))
    look = look.after(find_frozen(look.recording, look.columns, look.clock))
    look = look.after(motion.check_motion(look.recording, look.ratios, scaled=time_scale != 1.0))
    recording = look.recording
    if options.has_window:
        origin_s, part = look.clock.first_s if read_s is None else read_s, (options.t_start_s, options.t_end_s)
        recording = take_window(recording, look.clock, part, origin_s)
        look = look if recording.blocks is None else _Look(recording, listen)
    return recording if recording.blocks is None else look.concluded()
