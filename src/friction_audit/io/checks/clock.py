"""The order of the stamps: sorted where neighbours are swapped, refused where time runs backwards."""

from dataclasses import replace

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, Float

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
    backwards = int(np.count_nonzero(steps < 0.0))
    if backwards:
        text = (
            f"{backwards} rows are older than the row before them ({path} is not in order of time); the rows are sorted"
        )
        finding = Finding(code="unordered", message=text, amount=float(backwards))
        recording = recording.take_rows(np.argsort(recording.t, kind="stable")).with_findings(finding)
    new = np.ones(len(recording.t), dtype=np.bool_)
    np.greater(recording.t[1:], recording.t[:-1], out=new[1:])
    repeats = len(new) - int(np.count_nonzero(new))
    if repeats == 0:
        return recording
    text = (
        f"{repeats} of {len(new)} rows ({repeats / len(new):.1%}) carry the stamp of the row before them; "
        "the first of each stamp is kept"
    )
    finding = Finding(code="duplicate_stamps", message=text, amount=float(repeats))
    return recording.take_rows(new).with_findings(finding)


def _refuse_no_clock(recording: Recording, steps: Float, path: str) -> None:
    name, rows = recording.mapping.get("t", recording.clock), len(recording.t)
    if not steps.any():
        raise InputError(
            f"{path}: time ({name}) is the same in all {rows} rows; expected strictly increasing stamps; "
            "name another clock with --map t=<column>, or another topic"
        )
    backwards = int(np.count_nonzero(steps < 0.0))
    late_s = np.maximum.accumulate(recording.t) - recording.t
    worst = int(late_s.argmax())
    is_few = backwards <= max(_MOST_BACKWARDS * len(steps), 1.0)
    if late_s[worst] <= _LONGEST_BACKWARDS_S and is_few:
        return
    advice = "bring the rows into order"
    if is_few:
        starts = ", ".join(map(str, (np.flatnonzero(steps < 0.0) + 2)[:_SHOWN]))
        advice = (
            f"these look like {backwards + 1} recordings in one file: cut it before row {starts}"
            f"{'...' if backwards > _SHOWN else ''} and read each part"
        )
    raise InputError(
        f"{path}: time ({name}) goes back at {backwards} of {len(steps)} rows, by up to {late_s[worst]:.4g} s "
        f"at row {worst + 1}; expected increasing stamps; {advice}, or name another clock with --map t=<column>"
    )
