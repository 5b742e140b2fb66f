"""LogReport -> the same of some joints only, with names that fit above a panel: what one sheet of figures shows."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from friction_audit.audit import Estimate
from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.interaction.interaction import Interaction
from friction_audit.printable import printable, shortened
from friction_audit.report.estimate_table import joint_label
from friction_audit.report.figures.batch_look import LONGEST_NAME
from friction_audit.report.log_report import LogReport

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
