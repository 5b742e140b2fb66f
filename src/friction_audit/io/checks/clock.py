"""The order of the stamps: sorted where it is a matter of neighbours, refused where time runs backwards."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.checks.sampling import take_rows, with_findings
from friction_audit.io.readers.reader import Recording
from friction_audit.joint_log import Finding

_LONGEST_BACKWARDS_S = 1.0
_MOST_BACKWARDS = 0.01
_SHOWN = 5


def order_clock(recording: Recording, path: str, *, time_scale: float = 1.0) -> Recording:
    """Return the recording with strictly increasing stamps.

    Raises:
        InputError: If time stands still or runs backwards.
    """
    if time_scale != 1.0:
        recording = replace(recording, t=recording.t * time_scale)
    steps = np.diff(recording.t)
    if steps.min() > 0.0:
        return recording
    _refuse_no_clock(recording, steps, path)
    recording = _sort(recording, steps, path)
    return _drop_duplicates(recording)


def _refuse_no_clock(recording: Recording, steps: NDArray[np.float64], path: str) -> None:
    name = recording.mapping.get("t", recording.clock)
    if not steps.any():
        raise InputError(
            f"{path}: time ({name}) is the same in all {len(recording.t)} rows; expected strictly increasing stamps; "
            "name another clock with --map t=<column>, or another topic"
        )
    backwards = int(np.count_nonzero(steps < 0.0))
    behind = np.maximum.accumulate(recording.t) - recording.t
    worst = int(behind.argmax())
    if behind[worst] > _LONGEST_BACKWARDS_S or backwards > max(_MOST_BACKWARDS * len(steps), 1.0):
        starts = np.flatnonzero(steps < 0.0) + 2
        several = (
            f"these look like {backwards + 1} recordings in one file: cut it before row "
            f"{', '.join(map(str, starts[:_SHOWN]))}{'...' if backwards > _SHOWN else ''} and read each part"
            if backwards <= max(_MOST_BACKWARDS * len(steps), 1.0)
            else "bring the rows into order"
        )
        raise InputError(
            f"{path}: time ({name}) goes back at {backwards} of {len(steps)} rows, by up to {behind[worst]:.4g} s "
            f"at row {worst + 1}; expected increasing stamps; {several}, or name another clock with --map t=<column>"
        )


def _sort(recording: Recording, steps: NDArray[np.float64], path: str) -> Recording:
    backwards = int(np.count_nonzero(steps < 0.0))
    if backwards == 0:
        return recording
    message = (
        f"{backwards} rows are older than the row before them ({path} is not in order of time); the rows are sorted"
    )
    finding = Finding(code="unordered", message=message, amount=float(backwards))
    return with_findings(take_rows(recording, np.argsort(recording.t, kind="stable")), finding)


def _drop_duplicates(recording: Recording) -> Recording:
    new = np.ones(len(recording.t), dtype=np.bool_)
    np.greater(recording.t[1:], recording.t[:-1], out=new[1:])
    repeats = len(new) - int(np.count_nonzero(new))
    if repeats == 0:
        return recording
    message = (
        f"{repeats} of {len(new)} rows ({repeats / len(new):.1%}) carry the stamp of the row before them; "
        "the first of each stamp is kept"
    )
    finding = Finding(code="duplicate_stamps", message=message, amount=float(repeats))
    return with_findings(take_rows(recording, new), finding)
