"""The faults of a recording: each is noticed, named with its amount, and handled or refused, in a file of its own."""

from dataclasses import replace

from friction_audit.errors import InputError
from friction_audit.io.checks.blocks import WholeLogError, examine_in_blocks
from friction_audit.io.checks.clock import check_sampling, order_clock, spread_batches
from friction_audit.io.checks.motion import check_motion, mend_units, refuse_dead_velocity
from friction_audit.io.checks.torque import check_torque, drop_stale_samples
from friction_audit.io.checks.values import leave_out_missing, leave_out_wild
from friction_audit.io.recording import Recording
from friction_audit.joint_log import MINIMUM_SAMPLES


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
    if recording.blocks is not None:
        return examine_in_blocks(replace(recording, robot=robot or recording.robot), recording.blocks, path)
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


def _refuse_short(recording: Recording, path: str) -> None:
    samples = len(recording.t)
    if samples < MINIMUM_SAMPLES:
        said = "; ".join(finding.message for finding in recording.findings)
        raise InputError(
            f"{path}: {samples} sample{'' if samples == 1 else 's'}; at least {MINIMUM_SAMPLES} are needed for a joint "
            f"log{f' ({said})' if said else ''}; record the arm while it moves"
        )


__all__ = ["WholeLogError", "examine"]
