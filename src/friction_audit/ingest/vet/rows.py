"""Some rows or joints of a recording, column by column: no second copy of the whole is made."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.ingest.reader import Recording
from friction_audit.joint_log import Finding


def take_rows(recording: Recording, rows: NDArray[Any]) -> Recording:
    """Return the rows of a mask or in an order; works in place, one column at a time."""
    count = int(np.count_nonzero(rows)) if rows.dtype == np.bool_ else len(rows)
    for array in recording.channels.values():
        for column in array.T:
            column[:count] = column[rows]
    kept = {channel: array[:count] for channel, array in recording.channels.items()}
    return replace(recording, t=recording.t[rows], channels=kept)


def take_joints(recording: Recording, joints: Sequence[int]) -> Recording:
    """Return some joints only, given by column."""
    kept = {channel: np.asfortranarray(array[:, list(joints)]) for channel, array in recording.channels.items()}
    return replace(recording, channels=kept, joint_names=tuple(recording.joint_names[joint] for joint in joints))


def without_channels(recording: Recording, channels: Sequence[str]) -> Recording:
    """Return the recording without some channels."""
    return replace(
        recording,
        channels={channel: array for channel, array in recording.channels.items() if channel not in channels},
        mapping={channel: name for channel, name in recording.mapping.items() if channel not in channels},
    )


def with_findings(recording: Recording, *findings: Finding | None) -> Recording:
    """Return the recording with what was noticed added."""
    noticed = tuple(finding for finding in findings if finding is not None)
    return replace(recording, findings=(*recording.findings, *noticed)) if noticed else recording
