"""The faults of a recording: each is noticed, named with its amount, and handled or refused, in a file of its own."""

from dataclasses import replace

import numpy as np

from friction_audit.columns_on_demand import is_on_demand
from friction_audit.errors import InputError
from friction_audit.io.checks.clock import check_sampling, order_clock, spread_batches
from friction_audit.io.checks.motion import LARGEST_Q_RAD, check_motion, mend_units, refuse_dead_velocity
from friction_audit.io.checks.torque import check_torque, drop_stale_samples
from friction_audit.io.checks.values import leave_out_missing, leave_out_wild
from friction_audit.io.recording import Recording
from friction_audit.joint_log import MINIMUM_SAMPLES
from friction_audit.parallel import one_joint_at_a_time, per_joint, release_memory


class WholeLogError(Exception):
    """The columns of a log have to be examined together, and not one joint at a time."""


def examine(recording: Recording, *, path: str, robot: str | None = None, time_scale: float = 1.0) -> Recording:
    """Notice, handle or refuse the faults of a recording; its arrays are worked on in place.

    Args:
        recording: As a reader returned it.
        path: The file, for messages.
        robot: The robot that the user stated; wins over the recording's own.
        time_scale: Factor on the recording's clock.

    Raises:
        InputError: If it cannot be used.
    """
    if any(map(is_on_demand, recording.channels.values())):
        return _examine_joint_by_joint(recording, path, robot)
    _refuse_short(recording, path)
    rows_as_read = len(recording.t)
    if robot is not None:
        recording = replace(recording, robot=robot)
    recording = leave_out_missing(recording, path)
    _refuse_short(recording, path)
    recording = order_clock(recording, path, time_scale=time_scale)
    _refuse_short(recording, path)
    recording = spread_batches(recording)
    whole = recording.first_s is None
    first_s = float(recording.t[0]) if recording.first_s is None else recording.first_s * time_scale
    recording = leave_out_wild(recording, first_s=first_s, numbered=whole and len(recording.t) == rows_as_read)
    _refuse_short(recording, path)
    recording = refuse_dead_velocity(recording, path)
    recording = mend_units(recording, path)
    recording = check_sampling(recording)
    recording = drop_stale_samples(recording)
    _refuse_short(recording, path)
    recording = check_torque(recording)
    return check_motion(recording, path, scaled=time_scale != 1.0)


def _examine_joint_by_joint(recording: Recording, path: str, robot: str | None) -> Recording:
    """Examine one joint after the other, as long as none of them has a fault.

    Raises:
        WholeLogError: If one has: most faults concern the rows of all joints.
    """
    t = recording.t
    if len(t) < MINIMUM_SAMPLES or not np.isfinite(t).all() or not np.all(t[1:] > t[:-1]):
        raise WholeLogError
    recording = spread_batches(replace(recording, robot=robot or recording.robot))

    def windows_of(joint: int) -> int:
        with one_joint_at_a_time():
            windows = _windows_of_sound_joint(recording, joint, path)
        release_memory()
        return windows

    windows = sum(per_joint(windows_of, len(recording.joint_names)))
    return check_sampling(replace(recording, clock_windows=windows))


def _windows_of_sound_joint(recording: Recording, joint: int, path: str) -> int:
    """Return on how many windows the clock agrees with the motion of a joint without a fault."""
    channels = {name: array[:, joint][:, None] for name, array in recording.channels.items()}
    one = replace(recording, channels=channels, joint_names=recording.joint_names[joint : joint + 1], findings=())
    try:
        found = leave_out_wild(leave_out_missing(one, path), first_s=0.0, numbered=False)
        found = mend_units(refuse_dead_velocity(found, path), path)
        found = check_motion(check_torque(drop_stale_samples(found)), path, scaled=False)
    except InputError as error:
        raise WholeLogError from error
    # A joint that turns without end is in degrees or not by what the others do.
    if found.findings or max(channels["q"].max(), -channels["q"].min()) > LARGEST_Q_RAD:
        raise WholeLogError
    return found.clock_windows


def _refuse_short(recording: Recording, path: str) -> None:
    samples = len(recording.t)
    if samples < MINIMUM_SAMPLES:
        said = "; ".join(finding.message for finding in recording.findings)
        raise InputError(
            f"{path}: {samples} sample{'' if samples == 1 else 's'}; at least {MINIMUM_SAMPLES} are needed for a joint "
            f"log{f' ({said})' if said else ''}; record the arm while it moves"
        )
