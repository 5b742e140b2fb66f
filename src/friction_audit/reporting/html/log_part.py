"""LogReport -> the same of some joints only, with names that fit above a panel: what one sheet of figures shows."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from friction_audit.errors import printable, shortened
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.reporting.figures.batch_look import LONGEST_NAME
from friction_audit.reporting.html.page import Cell, Command, Section, Table, Text
from friction_audit.reporting.log_report import LogReport
from friction_audit.reporting.terminal.estimate import joint_label

PER_JOINT = ("initiation", "termination", "fastest", "standstill_rad_s", "moving_s")
"""Fields of EnergyCycles with one entry per joint."""
BESIDE = 9
"""Letters of a name that fit beside a panel, from bottom to top."""


def part_of(report: LogReport, numbers: Collection[int]) -> LogReport:
    """Return the report of some joints, given by their numbers for people; its estimate is for drawing only."""
    diagnosis, replayed = report.diagnosis, report.replay
    if diagnosis is not None:
        joints = tuple(
            replace(one, name=_fitting(one.joint, one.name))
            for one in diagnosis.discrepancy.joints
            if one.joint in numbers
        )
        diagnosis = replace(diagnosis, discrepancy=replace(diagnosis.discrepancy, joints=joints))
    if replayed is not None:
        own = tuple(
            replace(one, name=_fitting(one.joint, one.name, BESIDE))
            for one in replayed.replay.joints
            if one.joint in numbers
        )
        replayed = replace(replayed, replay=replace(replayed.replay, joints=own))
    return replace(report, estimate=_estimate(report.estimate, numbers), diagnosis=diagnosis, replay=replayed)


def _fitting(joint: int, name: str, most: int = LONGEST_NAME) -> str:
    """Return a name in so many letters, by default what fits above a panel; none where it says only the number."""
    return "" if joint_label(joint, name) == str(joint) else shortened(printable(name), most)


def _estimate(estimate: Estimate, numbers: Collection[int]) -> Estimate:
    columns = [k for k, number in enumerate(estimate.interaction.joint_numbers) if number in numbers]
    joints = tuple(
        replace(one, name=_fitting(one.joint, one.name)) for one in estimate.friction.joints if one.joint in numbers
    )
    return replace(
        estimate,
        interaction=_interaction(estimate.interaction, columns),
        cycles=_cycles(estimate.cycles, columns),
        friction=replace(estimate.friction, joints=joints),
    )


def _interaction(whole: Interaction, columns: list[int]) -> Interaction:
    compensation, gravity = whole.compensation, whole.gravity_direction
    return replace(
        whole,
        q=whole.q[:, columns],
        dq=whole.dq[:, columns],
        torque=whole.torque[:, columns],
        compensation=None if compensation is None else compensation[:, columns],
        gravity_direction=None if gravity is None else gravity[:, columns],
        joint_numbers=tuple(whole.joint_numbers[k] for k in columns),
        joint_names=tuple(_fitting(whole.joint_numbers[k], whole.joint_names[k]) for k in columns),
    )


def _cycles(cycles: EnergyCycles, columns: list[int]) -> EnergyCycles:
    """Return the cycles of some columns, counted anew."""
    kept = cycles.rows(np.isin(cycles.joint, columns))
    own = {name: getattr(kept, name)[columns] for name in PER_JOINT}
    return replace(kept, joint=np.searchsorted(columns, kept.joint), **own)


UNSET = "not set"


def settings_section(settings: Mapping[str, object], command: str) -> Section:
    """Return every setting, defaults included, and the command."""
    rows = [(Cell(text=name, code=True), Cell(text=value, code=True)) for name, value in flattened(settings)]
    table = Table(caption="Every setting, defaults included", titles=("setting", "value"), rows=rows, folded=True)
    again = (Text(lines=("This command makes the page again:",)), Command(line=command)) if command else ()
    return Section(anchor="settings", title="Settings", parts=(*again, table))


def flattened(settings: Mapping[str, object], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield each setting with its full name, ``outer.inner``, and its value as text."""
    for name, value in settings.items():
        full = f"{before}{name}"
        if isinstance(value, Mapping) and value:
            yield from flattened(value, f"{full}.")
        else:
            yield full, setting_text(value)


def setting_text(value: object) -> str:
    """Return a value as people read it."""
    match value:
        case None | {}:
            return UNSET
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:g}"
        case list() | tuple():
            return ", ".join(setting_text(item) for item in value) or UNSET
    return str(value)
