"""Everything the user must know about a result, from every step of the chain, in one list."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from friction_audit.joint_log import JointLog
from friction_audit.pipeline import Diagnosis, Estimate, LogReplay
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.reporting.units import NEWTON_METRES, in_unit

if TYPE_CHECKING:
    from rich.table import Table

    from friction_audit.compensation.result import JointReplay
    from friction_audit.drift.session import JointSummary
    from friction_audit.friction.history import JointFriction


IN_AMPERE = (
    "{0}: the torque column is a motor current: coefficients are in {1} and {1} s/rad, energies in {1} rad; keys of "
    "the JSON document that end in _nm hold {1}; gravity and inertia of a model are not removed; for newton metres, "
    "multiply the column by torque constant and gear ratio"
)


class Notice(NamedTuple):
    """A warning: stable short name, joint number for people or None, one sentence."""

    code: str
    joint: int | None
    message: str

    def __str__(self) -> str:
        """Return the sentence, led by the joint that it is about unless it names it already."""
        if self.joint is None or self.message.lower().startswith(f"joint {self.joint}"):
            return self.message
        return f"joint {self.joint}: {self.message}"


def log_notices(log: JointLog) -> tuple[Notice, ...]:
    """Return what was noticed while the log was read."""
    unit = log.source.torque_unit
    own = () if unit == NEWTON_METRES else (Notice("torque_in_ampere", None, IN_AMPERE.format(log.source.path, unit)),)
    return own + tuple(Notice(found.code, found.joint, found.message) for found in log.source.findings)


def interaction_notices(interaction: Interaction) -> tuple[Notice, ...]:
    """Return what was noticed while the interaction torque was made."""
    return tuple(Notice(found.code, found.joint, found.message) for found in interaction.warnings)


def estimate_notices(estimate: Estimate) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the coefficients, each once."""
    friction = tuple(Notice(found.code, found.joint, found.message) for found in estimate.friction.warnings)
    every = log_notices(estimate.log) + interaction_notices(estimate.interaction) + friction
    return _each_once(every, estimate.log)


def replay_notices(found: LogReplay) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the replay, each once; not what only concerns the estimate."""
    own = tuple(Notice(one.code, one.joint, one.message) for one in found.replay.warnings)
    every = log_notices(found.estimate.log) + interaction_notices(found.estimate.interaction) + own
    return _each_once(every, found.estimate.log)


def diagnose_notices(found: Diagnosis) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the diagnosis, each once.

    With limits of the data, and where energy and torque tell different friction.

    Of joints without an answer nothing: what is wrong with them is their answer.
    """
    limits = tuple(
        Notice(finding.code, joint.joint, finding.message)
        for joint in found.discrepancy.joints
        for finding in joint.findings
        if finding.verdict == "limit" and joint.gap is not None
    )
    # Where an effect was found, it is what makes the two differ.
    disagreements = tuple(
        Notice("energy_against_torque", joint.joint, sentence)
        for joint in found.discrepancy.joints
        for sentence in joint.disagreements
        if not joint.effects
    )
    of_log = log_notices(found.estimate.log) + interaction_notices(found.estimate.interaction)
    every = of_log + limits + disagreements
    return _each_once(every, found.estimate.log)


def _each_once(every: Iterable[Notice], log: JointLog) -> tuple[Notice, ...]:
    unit = log.source.torque_unit
    return tuple(dict.fromkeys(one._replace(message=in_unit(one.message, unit)) for one in every))


def notice_lines(notices: Iterable[Notice]) -> list[str]:
    """Return one line per sentence, led by the joints that it is about."""
    about: dict[str, list[Notice]] = {}
    for notice in notices:
        about.setdefault(notice.message, []).append(notice)
    return [_line(message, same) for message, same in about.items()]


def _line(message: str, same: list[Notice]) -> str:
    joints = list(dict.fromkeys(notice.joint for notice in same))
    if len(joints) == 1 or None in joints:
        return str(same[0])
    return f"joints {', '.join(map(str, joints))}: {message}"


WIDEST = 1000
"""Characters of a line."""


def plain_lines(table: "Table") -> list[str]:
    """Return a table as text, without spaces at the ends of its lines.

    It is as wide as the terminal, and wider where a column that keeps its lines would be cut: a terminal breaks long
    lines, and half a number is worse.
    """
    from rich.console import Console

    console = Console(highlight=False, markup=False, color_system=None)
    roomy = console.options.update(max_width=WIDEST)
    for column in table.columns:
        if column.no_wrap:
            cells = (column.header, *column.cells)
            own = column.min_width or 0
            column.min_width = max(own, *(console.measure(cell, options=roomy).maximum for cell in cells))
    console.width = max(console.width, console.measure(table, options=roomy).minimum)
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines()]


def reason_lines(joints: "Iterable[JointFriction | JointReplay | JointSummary]") -> list[str]:
    """Return one line per reason, led by the joints that it holds for; none for joints with a result."""
    reasons: dict[str, list[int]] = {}
    for joint in joints:
        if joint.reason:
            reasons.setdefault(joint.reason, []).append(joint.joint)
    return [f"{_name_joints(numbers)}: {reason}" for reason, numbers in reasons.items()]


def _name_joints(numbers: list[int]) -> str:
    return f"joint{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"
