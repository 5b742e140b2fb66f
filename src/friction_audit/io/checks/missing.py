"""What was not recorded: channels, joints and rows without numbers."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.checks.sampling import GAP_S, take_joints, take_rows, with_findings, without_channels
from friction_audit.io.readers.reader import Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding
from friction_audit.parallel import per_joint

_ESSENTIAL = ("q", "dq", *TORQUE_CHANNELS)
_ABSURD = 1e9
"""No position, velocity, torque or temperature of a joint is as large, in any unit: a damaged number."""
_SPARSE = 0.1
"""Share of missing values from which a channel that is not essential is left out, rather than the rows."""


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
    return _leave_out_rows(recording)


def _is_whole(column: NDArray[np.float64]) -> bool:
    # NaN goes through min and max: two fast passes and no temporary array.
    return bool(column.min() > -_ABSURD and column.max() < _ABSURD)


def _missing_per_joint(array: NDArray[np.float64]) -> NDArray[np.int64]:
    def missing(joint: int) -> int:
        column = array[:, joint]
        return 0 if _is_whole(column) else int(np.count_nonzero(~(np.abs(column) < _ABSURD)))

    return np.array(per_joint(missing, array.shape[1]), dtype=np.int64)


def _leave_out_channels(recording: Recording, missing: Mapping[str, NDArray[np.int64]], path: str) -> Recording:
    samples = len(recording.t)
    empty = [channel for channel, counts in missing.items() if (counts == samples).all()]
    sparse = [c for c, counts in missing.items() if c not in (*_ESSENTIAL, *empty) and counts.max() > _SPARSE * samples]
    _refuse_without(empty, recording, path)
    findings = [_empty_channel(channel, recording) for channel in empty]
    findings += [_sparse_channel(channel, int(missing[channel].max()), samples) for channel in sparse]
    return with_findings(without_channels(recording, (*empty, *sparse)), *findings)


def _refuse_without(empty: list[str], recording: Recording, path: str) -> None:
    """Refuse a recording whose position, velocity or only torque holds no number."""
    torques = [channel for channel in TORQUE_CHANNELS if channel in recording.channels]
    lost: list[str] = [channel for channel in ("q", "dq") if channel in empty]
    lost += torques if all(channel in empty for channel in torques) else []
    if lost:
        names = ", ".join(f"{channel} ({recording.mapping.get(channel, channel)})" for channel in lost)
        raise InputError(
            f"{path}: {names}: none of the {len(recording.t)} rows holds a number (all NaN, infinite or beyond "
            f"{_ABSURD:g}); expected "
            f"q, dq and one torque of {', '.join(TORQUE_CHANNELS)}; record a topic that "
            "carries them, such as the robot's own state"
        )


def _leave_out_joints(recording: Recording, missing: Mapping[str, NDArray[np.int64]], path: str) -> Recording:
    samples = len(recording.t)
    empty = np.zeros(len(recording.joint_names), dtype=np.bool_)
    for counts in missing.values():
        empty |= counts == samples
    if not empty.any():
        return recording
    kept = [int(joint) for joint in np.flatnonzero(~empty)]
    if not kept:
        raise InputError(
            f"{path}: no joint has q, dq and torque together; each lacks one of them in all {samples} rows"
        )
    findings = [
        Finding(
            code="empty_joint",
            message=f"{recording.joint_names[joint]} lacks a channel in all {samples} rows; the joint is left out",
            joint=int(joint) + 1,
            amount=float(samples),
        )
        for joint in np.flatnonzero(empty)
    ]
    return with_findings(take_joints(recording, kept), *findings)


def _leave_out_rows(recording: Recording) -> Recording:
    whole = np.isfinite(recording.t)
    for array in recording.channels.values():
        for column in array.T:
            if not _is_whole(column):
                whole &= np.abs(column) < _ABSURD
    lost = len(whole) - int(np.count_nonzero(whole))
    if lost == 0:
        return recording
    message = f"{lost} of {len(whole)} rows hold NaN, infinity or numbers beyond {_ABSURD:g}; they are left out"
    finding = Finding(code="non_finite", message=message, amount=float(lost), damaged=True)
    return with_findings(take_rows(recording, whole), finding)


def _empty_channel(channel: str, recording: Recording) -> Finding:
    name = recording.mapping.get(channel, channel)
    message = f"{channel} ({name}) holds no number in {len(recording.t)} rows; the channel is left out"
    return Finding(code="empty_channel", message=message, amount=float(len(recording.t)))


def _sparse_channel(channel: str, lost: int, samples: int) -> Finding:
    message = f"{channel} lacks {lost} of {samples} rows; the channel is left out, the rows are kept"
    return Finding(code="sparse_channel", message=message, amount=float(lost))


MOVING_RAD_S = 0.02
HELD_SHARE = 0.5
"""Share of stale rows, of those in motion, from which on the state itself is slow, and the logger did not stall."""
HELD_PERIODS = 3.5
"""A state that is held for more of its own periods did stall."""


def drop_stale_samples(recording: Recording) -> Recording:
    """Drop rows equal to the row before in q, dq and torque while some joint moves.

    A logger that polls faster than the state changes repeats it. At standstill equal rows are left alone: an ideal
    simulation at rest repeats itself rightly.
    """
    stale = find_stale(recording)
    if len(stale) == 0:
        return recording
    fresh = np.ones(len(recording.t), dtype=np.bool_)
    fresh[stale] = False
    recording = _keep_slow_state(recording, fresh)
    stale = np.flatnonzero(~fresh)
    if len(stale) == 0:
        return recording
    share = len(stale) / len(fresh)
    message = (
        f"{len(stale)} of {len(fresh)} rows ({share:.1%}) repeat q, dq and torque of the row before while the arm "
        "moves (the logger was faster than the state); they are left out"
    )
    return with_findings(
        take_rows(recording, fresh), Finding(code="stale_samples", message=message, amount=float(len(stale)))
    )


def find_stale(recording: Recording) -> NDArray[np.intp]:
    """Return the rows that repeat the row before them while some joint moves."""
    arrays = [recording.channels[c] for c in ("dq", "q", *TORQUE_CHANNELS) if c in recording.channels]
    columns = [column for array in arrays for column in array.T]
    first = columns[0]
    rows = np.flatnonzero(first[1:] == first[:-1]) + 1
    for column in columns[1:]:
        if len(rows) == 0:
            return rows
        rows = rows[column[rows] == column[rows - 1]]
    return rows[_moving(recording, rows)]


def _moving(recording: Recording, rows: NDArray[np.intp] | slice) -> NDArray[np.bool_]:
    moving = np.zeros(len(recording.t[rows]), dtype=np.bool_)
    for column in recording.channels["dq"].T:
        moving |= np.abs(column[rows]) > MOVING_RAD_S
    return moving


def _keep_slow_state(recording: Recording, fresh: NDArray[np.bool_]) -> Recording:
    """Mark stale rows as fresh where the state is new less often than a hole is long, as on a bus of many motors.

    Without them, each of its steps would pass for a hole in the log.
    """
    rows = np.flatnonzero(fresh)
    steps, repeats = np.diff(recording.t[rows]), np.diff(rows) - 1
    period = float(np.median(steps[repeats > 0])) if repeats.any() else 0.0
    moving = np.count_nonzero(_moving(recording, slice(None)))
    if HELD_PERIODS * period <= GAP_S or repeats.sum() < HELD_SHARE * moving:
        return recording
    held = (repeats > 0) & (steps <= HELD_PERIODS * period)
    for row in np.flatnonzero(held):
        fresh[rows[row] : rows[row + 1]] = True
    message = (
        f"q, dq and torque are new only every {period:.3g} s while the arm moves (a bus that asks one motor after the "
        f"other?); {repeats[held].sum()} rows that repeat them are kept"
    )
    return with_findings(recording, Finding(code="slow_state", message=message, amount=period))
