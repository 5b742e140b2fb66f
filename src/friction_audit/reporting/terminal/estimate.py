"""Estimate -> the table that people read."""

import math
import re
from typing import TYPE_CHECKING

from friction_audit.errors import printable, shortened
from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.pipeline import Estimate
from friction_audit.reporting.json.estimate import InfoEntry, TopicSummary
from friction_audit.reporting.log_summary import JointMotion, LogSummary
from friction_audit.reporting.terminal.plain import plain_lines, reason_lines
from friction_audit.reporting.units import in_unit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import RenderableType
    from rich.table import Table


NOTHING = "-"
MARK = "*"
"""Marks a joint whose coefficients are not from energy cycles."""
LONGEST_NAME = 24
"""Characters of a joint's name in tables and figures; no column and no panel has room for more."""
TITLES = (
    "joint",
    "Coulomb\n[N m]",
    "viscous\n[N m s/rad]",
    "cycles\n(out)",
    "cond.\nnumber",
    "torque\nCoulomb",
    "torque\nviscous",
)


def estimate_table(estimate: Estimate) -> "list[RenderableType]":
    """Return what was chosen, a row per joint, and the reasons of the joints that have no estimate."""
    from rich.text import Text

    unit = estimate.log.source.torque_unit
    parts: list[RenderableType] = [Text(line) for line in _head(estimate)]
    parts.extend(map(Text, plain_lines(_table(estimate.friction.joints, unit))))
    if any(joint.method != "energy" and not joint.reason for joint in estimate.friction.joints):
        parts.append(Text(f"{MARK} by a regression of the torque: too few energy cycles count"))
    parts.extend(Text(in_unit(f"not determined: {line}", unit)) for line in reason_lines(estimate.friction.joints))
    return parts


def _head(estimate: Estimate) -> tuple[str, ...]:
    log, choice, settings = estimate.log, estimate.interaction.choice, estimate.settings.friction
    samples = f"{len(log.t)} samples, {log.rate_hz:.6g} Hz, {log.duration_s:.6g} s"
    proof = "proved by the energy" if choice.sign_proved else "not proved by the energy"
    torque = "; ".join(text for text in (f"interaction torque: {choice.formula}", choice.reason) if text)
    choices = f"drive {choice.drive}, gravity {choice.gravity}, inertia {choice.inertia}; sign {proof}"
    estimator = (
        f"estimator: {estimate.friction.estimator}, {settings.model} model, "
        f"history over {settings.cycles_per_point} cycles; intervals are 95 %"
    )
    return f"{log.source.path}: {log.source.format}, {samples}", torque, choices, estimator


def _table(joints: tuple[JointFriction, ...], unit: str) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, collapse_padding=True)
    for title in in_unit(TITLES, unit):
        table.add_column(Text(title), justify="left" if title == TITLES[0] else "right", no_wrap=True)
    for joint in joints:
        table.add_row(*_row(joint))
    return table


def _row(joint: JointFriction) -> tuple[str, ...]:
    beside = joint.regression
    mark = f" {MARK}" if joint.method != "energy" and not joint.reason else ""
    return (
        joint_label(joint.joint, joint.name) + mark,
        format_coefficient(joint.coulomb),
        format_coefficient(joint.viscous),
        f"{joint.cycles} ({joint.rejected_cycles})",
        NOTHING if math.isnan(joint.condition_number) else f"{joint.condition_number:.3g}",
        # The comparison is for the eye: its intervals are in the JSON document.
        NOTHING if beside is None else format_coefficient(beside.coulomb).split()[0],
        NOTHING if beside is None else format_coefficient(beside.viscous).split()[0],
    )


def joint_label(joint: int, name: str) -> str:
    """Return the joint's number, and its name, cut where it is far too long, where that says more."""
    said = shortened(printable(name), LONGEST_NAME)
    return str(joint) if not said or re.search(rf"(?<!\d)0*{joint}$", name) else f"{joint} {said}"


def format_coefficient(coefficient: Coefficient) -> str:
    """Return value and 95 % interval with the digits that the interval leaves meaningful.

    Examples: ``0.245 ± 0.006``; ``0.25 +0.01/-0.03`` where the interval is lopsided.
    """
    if math.isnan(coefficient.value):
        return NOTHING
    up, down = coefficient.high - coefficient.value, coefficient.value - coefficient.low
    if math.isnan(up + down):
        return f"{coefficient.value:.4g}"
    digits = _digits(max(up, down))
    last = 10.0**-digits
    texts = [f"{side:.{digits}f}" for side in (coefficient.value, max(up, last), max(down, last))]
    if abs(up - down) <= LOPSIDED * max(up, down):
        return f"{texts[0]} ± {max(up, down, last):.{digits}f}"
    return f"{texts[0]} +{texts[1]}/-{texts[2]}"


LOPSIDED = 0.25
"""Share by which the two sides of an interval may differ and still be written as one."""
MOST_DIGITS = 4
"""No sensor of a joint is worth more, and the table stays narrower than a terminal."""


def _digits(width: float) -> int:
    """Return the decimals that show two figures of a width."""
    if width <= 0:
        return MOST_DIGITS
    return min(max(1 - math.floor(math.log10(width)), 0), MOST_DIGITS)


def info_table(entry: InfoEntry) -> "list[RenderableType]":
    """Return what is in one file."""
    from rich.text import Text

    parts: list[RenderableType] = [Text(entry.path, style="bold")]
    if len(entry.topics) > 1 or entry.summary is None:
        parts.extend(Text(f"  topic {_topic(topic)}") for topic in entry.topics)
    if entry.summary is not None:
        parts.extend(Text(f"  {line}") for line in _lines(entry.summary))
        parts.append(_table_info_table(entry.summary.joints))
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


def _table_info_table(joints: tuple[JointMotion, ...]) -> "Table":
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
        table.add_row(*_row_info_table(joint))
    return table


def _row_info_table(joint: JointMotion) -> tuple[str, ...]:
    return (
        joint_label(joint.joint, joint.name),
        f"{joint.peak_speed_rad_s:.3g}",
        f"{joint.range_rad:.3g}",
        NOTHING if joint.moving_s is None else f"{joint.moving_s:.3g}",
        *(NOTHING if n is None else str(n) for n in (joint.cycles, joint.open_cycles, joint.rejected_cycles)),
    )
