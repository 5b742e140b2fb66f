"""What was not recorded: channels, joints and rows without numbers."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.recording import Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding, Float
from friction_audit.parallel import per_joint

_ESSENTIAL = ("q", "dq", *TORQUE_CHANNELS)
ABSURD = 1e9  # no position, velocity, torque or temperature is as large, in any unit: a damaged number
_SPARSE = 0.1  # share of missing values from which a channel that is not essential is left out, rather than the rows

Counts = Mapping[str, NDArray[np.int64]]  # channel -> missing values of each joint


def leave_out_missing(recording: Recording, path: str) -> Recording:
    """Leave out channels and joints that were never recorded, then rows with anything missing.

    Raises:
        InputError: If nothing usable is left.
    """
    missing = {channel: _missing_per_joint(array) for channel, array in recording.channels.items()}
    if not any(counts.any() for counts in missing.values()) and bool(np.isfinite(recording.t).all()):
        return recording
    recording = _leave_out_channels(recording, missing, path)
    recording = _leave_out_joints(recording, {channel: missing[channel] for channel in recording.channels}, path)
    whole = np.isfinite(recording.t)
    for array in recording.channels.values():
        for column in array.T:
            if not _is_whole(column):
                whole &= np.abs(column) < ABSURD
    lost = len(whole) - int(np.count_nonzero(whole))
    if lost == 0:
        return recording
    message = f"{lost} of {len(whole)} rows hold NaN, infinity or numbers beyond {ABSURD:g}; they are left out"
    finding = Finding(code="non_finite", message=message, amount=float(lost), damaged=True)
    return recording.take_rows(whole).with_findings(finding)


def _is_whole(column: Float) -> bool:
    # NaN goes through min and max: two fast passes and no temporary array.
    return bool(column.min() > -ABSURD and column.max() < ABSURD)


def _missing_per_joint(array: Float) -> NDArray[np.int64]:
    def missing(joint: int) -> int:
        column = array[:, joint]
        return 0 if _is_whole(column) else int(np.count_nonzero(~(np.abs(column) < ABSURD)))

    return np.array(per_joint(missing, array.shape[1]), dtype=np.int64)


def _leave_out_channels(recording: Recording, missing: Counts, path: str) -> Recording:
    samples = len(recording.t)
    empty = [channel for channel, counts in missing.items() if (counts == samples).all()]
    sparse = [c for c, counts in missing.items() if c not in (*_ESSENTIAL, *empty) and counts.max() > _SPARSE * samples]
    names = {channel: f"{channel} ({recording.mapping.get(channel, channel)})" for channel in empty}
    torques = [channel for channel in TORQUE_CHANNELS if channel in recording.channels]
    lost: list[str] = [channel for channel in ("q", "dq") if channel in empty]
    lost += torques if all(channel in empty for channel in torques) else []
    if lost:
        raise InputError(
            f"{path}: {', '.join(names[channel] for channel in lost)}: none of the {samples} rows holds a number (all "
            f"NaN, infinite or beyond {ABSURD:g}); expected q, dq and one torque of {', '.join(TORQUE_CHANNELS)}; "
            "record a topic that carries them, such as the robot's own state"
        )
    findings = []
    for channel in empty:
        text = f"{names[channel]} holds no number in {samples} rows; the channel is left out"
        findings.append(Finding(code="empty_channel", message=text, amount=float(samples)))
    for channel in sparse:
        few = int(missing[channel].max())
        text = f"{channel} lacks {few} of {samples} rows; the channel is left out, the rows are kept"
        findings.append(Finding(code="sparse_channel", message=text, amount=float(few)))
    return recording.without_channels((*empty, *sparse)).with_findings(*findings)


def _leave_out_joints(recording: Recording, missing: Counts, path: str) -> Recording:
    samples = len(recording.t)
    empty = np.zeros(len(recording.joint_names), dtype=np.bool_)
    for counts in missing.values():
        empty |= counts == samples
    if not empty.any():
        return recording
    if empty.all():
        raise InputError(
            f"{path}: no joint has q, dq and torque together; each lacks one of them in all {samples} rows"
        )
    findings = []
    for joint in map(int, np.flatnonzero(empty)):
        text = f"{recording.joint_names[joint]} lacks a channel in all {samples} rows; the joint is left out"
        findings.append(Finding(code="empty_joint", message=text, joint=joint + 1, amount=float(samples)))
    return recording.take_joints([int(joint) for joint in np.flatnonzero(~empty)]).with_findings(*findings)
