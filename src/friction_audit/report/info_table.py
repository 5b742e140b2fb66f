"""InfoEntry -> the text that people read."""

from typing import TYPE_CHECKING

from friction_audit.report.estimate_table import NOTHING, joint_label
from friction_audit.report.info_document import InfoEntry, TopicSummary
from friction_audit.report.log_summary import JointMotion, LogSummary

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import RenderableType
    from rich.table import Table


def info_table(entry: InfoEntry) -> "list[RenderableType]":
    """Return what is in one file."""
    from rich.text import Text

    parts: list[RenderableType] = [Text(entry.path, style="bold")]
    if len(entry.topics) > 1 or entry.summary is None:
        parts.extend(Text(f"  topic {_topic(topic)}") for topic in entry.topics)
    if entry.summary is not None:
        parts.extend(Text(f"  {line}") for line in _lines(entry.summary))
        parts.append(_table(entry.summary.joints))
    else:
        parts.append(Text(f"  not read: {entry.message}"))
    return parts


def _topic(topic: TopicSummary) -> str:
    messages = "" if topic.messages is None else f", {count(topic.messages, 'message')}"
    return f"{topic.name} ({topic.type}{messages}{'' if topic.readable else '; no joint log'})"


def _lines(summary: LogSummary) -> "Iterator[str]":
    log, torque = summary.log, summary.torque
    topic = f", topic {log.source.topic}" if log.source.topic else ""
    yield f"format   {log.source.format}{topic}, robot {log.source.robot}, {count(len(log.joint_names), 'joint')}"
    yield (
        f"clock    {log.source.clock}, {log.duration_s:.6g} s, {count(len(log.t), 'sample')}, {log.rate_hz:.6g} Hz, "
        f"{summary.clock_check}"
    )
    gaps = f"{count(summary.gaps, 'gap')}, the longest {summary.longest_gap_s:.3g} s" if summary.gaps else "no gaps"
    stale = f"{count(summary.stale_samples, 'repeated sample')} left out"
    yield f"steps    {summary.jitter}, {gaps}, {stale}"
    for channel, name in log.source.channels.items():
        yield f"channel  {channel} = {name}"
    if log.source.torque_unit != "N m":
        yield f"unit     the torque is a motor current and is read in {log.source.torque_unit}"
    if torque is not None:
        sign = "sign proved by the energy" if torque.sign_proved else "sign not proved"
        yield f"torque   {torque.formula}; drive {torque.drive}, gravity {torque.gravity}, {sign}"


def count(number: int, thing: str) -> str:
    """Return ``"1 gap"``, ``"2 gaps"``."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def _table(joints: tuple[JointMotion, ...]) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    table.add_column("joint", overflow="fold")
    for title in (
        "peak speed\n[rad/s]",
        "range\n[rad]",
        "moving\n[s]",
        "cycles",
        "open in\nposition",
        "to be\nleft out",
    ):
        table.add_column(title, justify="right")
    for joint in joints:
        table.add_row(*_row(joint))
    return table


def _row(joint: JointMotion) -> tuple[str, ...]:
    return (
        joint_label(joint.joint, joint.name),
        f"{joint.peak_speed_rad_s:.3g}",
        f"{joint.range_rad:.3g}",
        NOTHING if joint.moving_s is None else f"{joint.moving_s:.3g}",
        *(NOTHING if n is None else str(n) for n in (joint.cycles, joint.open_cycles, joint.rejected_cycles)),
    )
