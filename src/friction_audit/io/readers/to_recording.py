"""Mapped columns and their numbers -> Recording."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.columns import ColumnMap
from friction_audit.io.readers.joint_samples import robot_of
from friction_audit.io.readers.reader import ReadOptions, Recording
from friction_audit.io.readers.time_column import Clock
from friction_audit.joint_log import Finding, Float

RADIANS_PER_DEGREE = np.pi / 180.0


def stated_arm(path: Path, options: ReadOptions) -> str:
    """Return the arm asked for with ``--topic '#ARM'``, or ""; a table has no topics, but it may hold several arms.

    Raises:
        InputError: If a topic was stated.
    """
    topic, _, arm = (options.topic or "").partition("#")
    if topic or (options.topic is not None and not arm):
        raise InputError(f"{path}: a table has no topics, and --topic asks for {options.topic}; leave --topic out")
    return arm


def to_recording(
    columns: ColumnMap, clock: Clock, channels: Mapping[str, Float], *, findings: tuple[Finding, ...] = ()
) -> Recording:
    """Return the recording of a table; channels whose names say degrees are turned into radians in place."""
    for channel in columns.degrees:
        array = channels[channel]
        array *= RADIANS_PER_DEGREE
    recording = Recording(
        t=clock.t,
        channels=dict(channels),
        joint_names=columns.joint_names,
        clock=columns.time.clock,
        start_s=clock.start_s,
        robot=columns.robot,
        mapping={"t": f"{columns.time.name} [{clock.unit}]", **columns.mapping},
    )
    return replace(recording, findings=(*columns.findings, *findings))


def name_joints(recording: Recording, names: Sequence[str], robot: str = "unknown") -> Recording:
    """Name the joints as the file says beside its columns, unless that is another number of joints."""
    if len(names) != len(recording.joint_names):
        return recording
    told = robot if robot != "unknown" else robot_of(names)
    return replace(recording, joint_names=tuple(names), robot=recording.robot if told == "unknown" else told)
