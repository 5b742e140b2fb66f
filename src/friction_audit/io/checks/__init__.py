"""Recording -> JointLog: every fault of a recording is noticed, named with its amount, and handled or refused.

``examine`` runs the checks in their order, each in its own file; ``to_joint_log`` proves the invariants.
"""

from dataclasses import replace

from friction_audit.errors import InputError
from friction_audit.io.checks.clock import order_clock
from friction_audit.io.checks.missing import drop_stale_samples, leave_out_missing
from friction_audit.io.checks.motion import check_motion, mend_units, refuse_dead_velocity
from friction_audit.io.checks.sampling import check_sampling, spread_batches
from friction_audit.io.checks.torque import check_torque
from friction_audit.io.checks.wild import leave_out_wild
from friction_audit.io.readers.channel_names import torque_unit
from friction_audit.io.readers.reader import ReadOptions, Recording
from friction_audit.joint_log import MINIMUM_SAMPLES, TORQUE_CHANNELS, JointLog, Source


def examine(recording: Recording, *, path: str, options: ReadOptions) -> Recording:
    """Notice, handle or refuse the faults of a recording; its findings grow.

    The recording's arrays are worked on in place.

    Raises:
        InputError: If it cannot be used.
    """
    _refuse_short(recording, path)
    rows_as_read = len(recording.t)
    if options.robot is not None:
        recording = replace(recording, robot=options.robot)
    recording = leave_out_missing(recording, path)
    _refuse_short(recording, path)
    recording = order_clock(recording, path, time_scale=options.time_scale)
    _refuse_short(recording, path)
    recording = spread_batches(recording)
    whole = recording.first_s is None
    first_s = float(recording.t[0]) if recording.first_s is None else recording.first_s * options.time_scale
    recording = leave_out_wild(recording, first_s=first_s, numbered=whole and len(recording.t) == rows_as_read)
    _refuse_short(recording, path)
    recording = refuse_dead_velocity(recording, path)
    recording = mend_units(recording, path)
    recording = check_sampling(recording)
    recording = drop_stale_samples(recording)
    _refuse_short(recording, path)
    recording = check_torque(recording)
    return check_motion(recording, path, scaled=options.time_scale != 1.0)


def to_joint_log(recording: Recording, *, path: str, sha256: str, format: str) -> JointLog:  # noqa: A002
    """Make an examined recording a JointLog whose clock starts at 0."""
    first = float(recording.t[0])
    source = Source(
        path=path,
        sha256=sha256,
        format=format,
        robot=recording.robot,
        serial=recording.serial,
        clock=recording.clock,
        start_s=None if recording.start_s is None else recording.start_s + first,
        topic=recording.topic,
        channels=dict(recording.mapping),
        torque_unit=_torque_unit(recording),
        clock_windows=recording.clock_windows,
        findings=recording.findings,
    )
    t = recording.t if first == 0.0 else recording.t - first
    return JointLog(t=t, **recording.channels, joint_names=recording.joint_names, source=source)


def _torque_unit(recording: Recording) -> str:
    """Return the unit that the name of the first torque channel says."""
    channel = next(name for name in TORQUE_CHANNELS if name in recording.channels)
    return torque_unit(recording.mapping.get(channel, ""))


def _refuse_short(recording: Recording, path: str) -> None:
    samples = len(recording.t)
    if samples < MINIMUM_SAMPLES:
        said = "; ".join(finding.message for finding in recording.findings)
        raise InputError(
            f"{path}: {samples} sample{'' if samples == 1 else 's'}; at least {MINIMUM_SAMPLES} are needed for a joint "
            f"log{f' ({said})' if said else ''}; record the arm while it moves"
        )
