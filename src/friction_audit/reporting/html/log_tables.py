"""LogReport -> the tables of its page."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

from friction_audit.compensation.result import JointReplay
from friction_audit.diagnosis.result import Effect, JointDiscrepancy
from friction_audit.friction.history import JointFriction
from friction_audit.preprocessing.interaction import SignEvidence
from friction_audit.reporting.figures.diagnose_look import names_of
from friction_audit.reporting.html.page import Cell, Table, Tone
from friction_audit.reporting.log_report import LogReport
from friction_audit.reporting.log_summary import JointMotion, LogSummary
from friction_audit.reporting.log_words import ESTIMATED, NO_ESTIMATE, WORDS
from friction_audit.reporting.terminal.diagnose import effect_numbers, format_p_value, format_torque
from friction_audit.reporting.terminal.estimate import NOTHING, format_coefficient, joint_label

TONES: Mapping[str, Tone] = {
    WORDS["none"]: "fine",
    WORDS["named"]: "alert",
    WORDS["ambiguous"]: "unsure",
    WORDS["unexplained"]: "alert",
    WORDS["not_testable"]: "off",
    WORDS["data_fault"]: "alert",
    WORDS["failed"]: "alert",
    NO_ESTIMATE: "off",
    ESTIMATED: "fine",
}
FINDING_TONES: Mapping[str, Tone] = {"fine": "fine", "limit": "unsure", "fault": "alert"}


def joint_cell(joint: int, name: str) -> Cell:
    """Return the cell that heads the row of a joint."""
    return Cell(text=joint_label(joint, name), key=joint)


def number_cell(value: float | None, form: str = ".3g") -> Cell:
    """Return a number, a dash where there is none."""
    known = value is not None and not math.isnan(value)
    return Cell(text=f"{value:{form}}" if known else NOTHING, key=value if known else math.nan)


def _filled(table: Table) -> Table:
    """Return a table without the columns that say nothing of any joint."""
    kept = [k for k in range(len(table.titles)) if any(row[k].text != NOTHING for row in table.rows)]
    return replace(
        table,
        titles=[table.titles[k] for k in kept],
        rows=[[row[k] for k in kept] for row in table.rows],
        numbers=frozenset(place for place, k in enumerate(kept) if k in table.numbers),
    )


def channel_table(report: LogReport) -> Table:
    """Return how the columns or fields of the log were understood."""
    channels = report.estimate.log.source.channels
    rows = [(Cell(text=channel), Cell(text=name, code=True)) for channel, name in channels.items()]
    caption = "Channels as they are called in the log, {i} standing for the joint"
    return Table(caption=caption, titles=("channel", "name in the log"), rows=rows, folded=True)


def motion_table(summary: LogSummary) -> Table:
    """Return how the joints moved."""
    return Table(
        caption="How the joints moved",
        titles=(
            "joint",
            "peak speed [rad/s]",
            "range [rad]",
            "moving [s]",
            "cycles",
            "open in position",
            "to be left out",
        ),
        rows=[_motion_row(joint) for joint in summary.joints],
        numbers=frozenset(range(1, 7)),
    )


def _motion_row(joint: JointMotion) -> tuple[Cell, ...]:
    return (
        joint_cell(joint.joint, joint.name),
        number_cell(joint.peak_speed_rad_s),
        number_cell(joint.range_rad),
        number_cell(joint.moving_s),
        number_cell(joint.cycles, "d"),
        number_cell(joint.open_cycles, "d"),
        number_cell(joint.rejected_cycles, "d"),
    )


def sign_table(report: LogReport) -> tuple[Table, ...]:
    """Return what the energy of each joint says about the sign of its torque, if that was looked at."""
    choice, names = report.estimate.interaction.choice, report.estimate.log.joint_names
    rows = [_sign_row(one, names[one.joint - 1]) for one in choice.sign_evidence]
    table = Table(
        caption="Proof of the torque's sign: friction takes energy, so the torque goes with the motion",
        titles=("joint", "energy", "moving [s]", "path [rad]", "torque with the motion [N m]", "standard error [N m]"),
        rows=rows,
        numbers=frozenset(range(2, 6)),
        folded=True,
    )
    return (table,) if rows else ()


def _sign_row(one: SignEvidence, name: str) -> tuple[Cell, ...]:
    return (
        joint_cell(one.joint, name),
        Cell(text=one.verdict),
        number_cell(one.moving_s),
        number_cell(one.path_rad),
        number_cell(one.against_motion_nm),
        number_cell(one.standard_error_nm, ".2g"),
    )


def data_tables(report: LogReport) -> Iterator[Table]:
    """Yield what the audit of the data found: what is not fine, and all of it."""
    joints = () if report.diagnosis is None else report.diagnosis.discrepancy.joints
    every = [(joint, found) for joint in joints for found in joint.findings]
    rows = [
        (
            joint_cell(joint.joint, joint.name),
            Cell(text=found.code, code=True),
            Cell(text=found.verdict, tone=FINDING_TONES[found.verdict]),
            number_cell(found.value),
            number_cell(found.bound),
            Cell(text=found.unit or NOTHING),
            Cell(text=found.message or NOTHING),
        )
        for joint, found in every
    ]
    titles = ("joint", "check", "verdict", "found", "bound", "unit", "what it means")
    bad = [row for row, (_, found) in zip(rows, every, strict=True) if found.verdict != "fine"]
    numbers = frozenset({3, 4})
    if bad:
        yield Table(caption="Limits and faults of the data", titles=titles, rows=bad, numbers=numbers)
    if rows:
        yield Table(caption="Every check of the data", titles=titles, rows=rows, numbers=numbers, folded=True)


def coefficient_table(report: LogReport) -> Table:
    """Return the coefficients over the whole log with their intervals, and why there are none."""
    return _filled(
        Table(
            caption="Coefficients over the whole log with 95 % intervals; beside them a regression of the torque",
            titles=(
                "joint",
                "Coulomb [N m]",
                "viscous [N m s/rad]",
                "cycles",
                "left out",
                "condition number",
                "torque: Coulomb [N m]",
                "torque: viscous [N m s/rad]",
                "remark",
            ),
            rows=[_coefficient_row(joint) for joint in report.estimate.friction.joints],
            numbers=frozenset(range(1, 8)),
        )
    )


def _coefficient_row(joint: JointFriction) -> tuple[Cell, ...]:
    beside = joint.regression
    return (
        joint_cell(joint.joint, joint.name),
        Cell(text=format_coefficient(joint.coulomb), key=joint.coulomb.value),
        Cell(text=format_coefficient(joint.viscous), key=joint.viscous.value),
        number_cell(joint.cycles, "d"),
        number_cell(joint.rejected_cycles, "d"),
        number_cell(joint.condition_number),
        *(
            Cell(text=NOTHING if one is None else format_coefficient(one), key=math.nan if one is None else one.value)
            for one in ((None, None) if beside is None else (beside.coulomb, beside.viscous))
        ),
        Cell(text=f"no estimate: {joint.reason}" if joint.reason else NOTHING),
    )


def replay_table(joints: tuple[JointReplay, ...]) -> Table:
    """Return what a compensator would have come to on every joint, and why on some to nothing."""
    return _filled(
        Table(
            caption="Energy and torque of the person without the compensator and with it",
            titles=(
                "joint",
                "energy without [J]",
                "with [J]",
                "removed [%]",
                "once it has learnt [%]",
                "peak torque without [N m]",
                "with [N m]",
                "cycles to converge",
                "damped [J]",
                "passive",
                "remark",
            ),
            rows=[_replay_row(joint) for joint in joints],
            numbers=frozenset(range(1, 9)),
        )
    )


def _replay_row(joint: JointReplay) -> tuple[Cell, ...]:
    numbers, passivity, head = joint.numbers, joint.passivity, joint_cell(joint.joint, joint.name)
    if numbers is None or passivity is None:
        return head, *(Cell(text=NOTHING, key=math.nan) for _ in range(9)), Cell(text=joint.reason or NOTHING)
    ran = math.isnan(numbers.diverged_s)
    passive = f"yes, acted in {passivity.active_cycles} cycles" if passivity.violations == 0 else "no"
    return (
        head,
        number_cell(numbers.energy_without_j),
        number_cell(numbers.energy_with_j),
        number_cell(100 * numbers.dissipation_removed if ran else None, ".1f"),
        number_cell(100 * numbers.dissipation_removed_updated if ran else None, ".1f"),
        number_cell(numbers.peak_torque_without_nm),
        number_cell(numbers.peak_torque_with_nm),
        number_cell(numbers.cycles_to_converge, "d"),
        number_cell(passivity.injected_j),
        Cell(text=passive),
        Cell(text=joint.reason or ("" if ran else f"diverges at {numbers.diverged_s:.3g} s") or NOTHING),
    )


def gap_table(joints: tuple[JointDiscrepancy, ...]) -> Table:
    """Return verdict and gap of every joint."""
    return _filled(
        Table(
            caption="Gap between model and measurement on cycles that no choice was made on, rms",
            titles=(
                "joint",
                "verdict",
                "missing",
                "before [N m]",
                "after [N m]",
                "floor [N m]",
                "closed [%]",
                "locked cycles",
                "simulated motion before [rad/s]",
                "after [rad/s]",
                "detection limit [N m]",
            ),
            rows=[_gap_row(joint) for joint in joints],
            numbers=frozenset(range(3, 11)),
        )
    )


def _gap_row(joint: JointDiscrepancy) -> tuple[Cell, ...]:
    gap, motion, word = joint.gap, joint.simulation, WORDS[joint.verdict]
    added = gap is not None and bool(joint.effects)
    return (
        joint_cell(joint.joint, joint.name),
        Cell(text=word, tone=TONES[word]),
        Cell(text=" and ".join(names_of(effect, joint.effects) for effect in joint.effects) or NOTHING),
        number_cell(None if gap is None else gap.before),
        number_cell(gap.after if gap is not None and added else None),
        number_cell(None if gap is None else gap.floor),
        number_cell(100 * gap.shrink if gap is not None and added else None, ".1f"),
        number_cell(None if gap is None else gap.cycles, "d"),
        number_cell(None if motion is None else motion.before),
        number_cell(motion.after if motion is not None and added else None),
        number_cell(joint.detection_limit_nm, ".2g"),
    )


def effect_table(joints: tuple[JointDiscrepancy, ...]) -> tuple[Table, ...]:
    """Return the effects that were named, with their numbers, if there are any."""
    rows = [_effect_row(joint, effect) for joint in joints for effect in joint.effects]
    table = Table(
        caption="What is missing, the strongest effect of a joint first; intervals are 95 %",
        titles=("joint", "effect", "gap [N m]", "p", "where", "numbers"),
        rows=rows,
        numbers=frozenset({2, 3}),
    )
    return (table,) if rows else ()


def _effect_row(joint: JointDiscrepancy, effect: Effect) -> tuple[Cell, ...]:
    return (
        joint_cell(joint.joint, joint.name),
        Cell(text=f"{names_of(effect, joint.effects)}: {effect.label}"),
        Cell(
            text=f"{format_torque(effect.gap_before_nm)} to {format_torque(effect.gap_after_nm)}",
            key=effect.gap_before_nm - effect.gap_after_nm,
        ),
        Cell(text=format_p_value(effect.p_value).removeprefix("p ").removeprefix("= ") or NOTHING, key=effect.p_value),
        Cell(text=effect.where, words=True),
        Cell(text=effect_numbers(effect) or NOTHING),
    )


def decision_table(joints: tuple[JointDiscrepancy, ...]) -> tuple[Table, ...]:
    """Return the motion that would decide between effects which the log does not tell apart, if there are any."""
    rows = [
        (joint_cell(joint.joint, joint.name), Cell(text=names_of(effect, joint.effects)), Cell(text=effect.decide))
        for joint in joints
        for effect in joint.effects
        if effect.decide
    ]
    caption = "What to record to decide between effects that this log does not tell apart"
    return (Table(caption=caption, titles=("joint", "effects", "motion"), rows=rows),) if rows else ()


def rival_table(joints: tuple[JointDiscrepancy, ...]) -> tuple[Table, ...]:
    """Return how the rivals of the effects did, if there are any."""
    rows = [
        (
            joint_cell(joint.joint, joint.name),
            Cell(text=effect.name),
            Cell(text=rival.name),
            number_cell(rival.delta_bic, "+.0f"),
            number_cell(rival.correlation, ".2f"),
        )
        for joint in joints
        for effect in joint.effects
        for rival in effect.evidence
        if rival.name != effect.name
    ]
    table = Table(
        caption="Rivals in the place of each effect: above zero they explain less, from 6 on clearly",
        titles=("joint", "effect", "rival", "difference in BIC", "correlation"),
        rows=rows,
        numbers=frozenset({3, 4}),
        folded=True,
    )
    return (table,) if rows else ()


def untestable_table(joints: tuple[JointDiscrepancy, ...]) -> tuple[Table, ...]:
    """Return which effects this log cannot show, and the motion that they lack, if there are any."""
    rows: list[tuple[Cell, ...]] = []
    for joint in joints:
        reasons: dict[str, list[str]] = {}
        for name, reason in joint.untestable.items():
            reasons.setdefault(reason, []).append(name)
        head = joint_cell(joint.joint, joint.name)
        rows += [(head, Cell(text=", ".join(names)), Cell(text=reason)) for reason, names in reasons.items()]
    caption = "Effects that this log cannot show, and why"
    return (Table(caption=caption, titles=("joint", "effects", "why"), rows=rows, folded=True),) if rows else ()
