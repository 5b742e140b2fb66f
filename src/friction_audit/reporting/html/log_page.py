"""LogReport -> one HTML page: the answer and the velocity-torque sheet first, details by joint and by topic folded."""

from collections.abc import Iterator
from dataclasses import replace

from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.reporting.diagnosis import data_tables
from friction_audit.reporting.diagnosis_tables import (
    COMPETITOR,
    EFFECT,
    JOINT_DIAGNOSIS,
    UNTESTABLE,
    effect_rows,
    untestable_rows,
)
from friction_audit.reporting.diagnosis_words import (
    decide_words,
    names_of,
    negligible_words,
    nominal_model,
    plain_names,
    remainder_words,
)
from friction_audit.reporting.estimate import FRICTION, sign_text
from friction_audit.reporting.html.log_figures import Drawn, draw_figures
from friction_audit.reporting.html.page import (
    Page,
    Part,
    Section,
    Terms,
    Text,
    citation_section,
    settings_section,
    terms_of,
)
from friction_audit.reporting.info import MOTION, LogSummary, summarize_log
from friction_audit.reporting.notices import estimate_notices, notice_lines, notices, physics_of, reason_lines
from friction_audit.reporting.replay import JOINT_REPLAY, describe_compensator
from friction_audit.reporting.report import (
    VERDICT,
    JointReport,
    LogReport,
    friction_words,
    lead_sentence,
    report_notices,
    report_settings,
    verdict_word,
)
from friction_audit.reporting.table import Column, JointName, Record, Table, joint_column
from friction_audit.reporting.words import MARK, count_of, format_start, in_unit, joint_label, joints_label

NO_FIGURES = Drawn({}, {})
WORDS = {
    "interaction torque": "F_m, the torque at the joint's torque sensor that drives the joint against friction and "
    "inertia.",
    "energy cycle": "From one moment of rest to the next: no energy is stored in the motion at either end, so that "
    "the energy put in is the energy that friction dissipated.",
    "Coulomb, viscous": "Friction that does not depend on the speed, and friction that grows with it.",
    "95 % interval": "Holds noise and the differences between cycles; not errors of the model, such as a wrong "
    "payload.",
    "condition number": "How well the cycles separate the two coefficients; from some hundreds on they do not.",
    "adequate": "No effect of the catalogue above the detection limit is missing from the model; a smaller one may be.",
    "named": "The joint shows an effect that inertia, Coulomb and viscous friction do not explain, and the log "
    "identifies it.",
    "ambiguous": "An effect is missing, and this log does not distinguish it from another one.",
    "unexplained": "No effect of the catalogue explains most of what is missing.",
    "not testable": "The log lacks the motion that a test needs.",
    "data fault": "The data are inconsistent, or a channel is dead: no conclusion is possible.",
    "failed": "A bug ended the diagnosis of the joint; the other joints are answered.",
    "residual RMS": "Torque that a model leaves unexplained, as root mean square; each cycle is held out once.",
    "noise floor": "Residual RMS of the noise alone; no model of the motion gets below it.",
    "share explained": "Share of the way from the residual RMS of the nominal model to the noise floor.",
    "size": "RMS of the torque of an effect, free of what the nominal model fits of it. Major from 10 % of the joint's "
    "friction on; negligible below 1 %, listed apart.",
    "chosen in folds": "Selections, each without a fifth of the cycles, that chose the effect.",
    "removed": "Share of the energy put in that the compensator would have removed; energy given out counts as left.",
    "passive": "The compensated joint never gave out more energy than was put into it.",
}
RECORD = (
    "To record: move one joint at a time, back and forth over most of its range, at least twelve times, at three or "
    "more speeds, with a rest at each end; then several joints together. Log q, dq and the joint torque at 100 Hz or "
    "more, with nothing touching the arm where it moves by itself."
)
CHANNEL = Record(
    (
        Column("channel", str, get="0", title="channel", on="p"),
        Column("name", str, get="1", title="name in the log", code=True, on="p"),
    )
)
SIGN = Record(
    (
        joint_column("0"),
        Column("energy", str, get="1.verdict", title="energy", on="p"),
        Column("moving", float, get="1.moving_s", unit="s", title="moving", on="p"),
        Column("path", float, get="1.path_rad", unit="rad", title="path", on="p"),
        Column("with_motion", get="1.against_motion_nm", unit="N m", title="torque with the motion", on="p"),
        Column("error", get="1.standard_error_nm", form=".2g", unit="N m", title="standard error", on="p"),
    )
)


def log_page(report: LogReport, *, figures: bool = True) -> Page:
    """Return what the page of a log is made of, with figures or without."""
    drawn = draw_figures(report) if figures else NO_FIGURES
    topics = {"friction": _friction, "diagnosis": _missing, "compensator": _compensator, "recording": _recording}
    answered = [one for one in report.joints if not one.friction.reason or one.answer]
    warnings = notice_lines(report_notices(report))
    listed = Text(lines=warnings or ("There are none.",), listed=bool(warnings), tone="unsure" if warnings else "")
    joints = Section(
        anchor="joints", title="Joints", sections=[_joint(report, one) for one in answered], on_paper=False
    )
    return Page(
        title=f"Joint friction: {report.file_name}",
        lead=in_unit(lead_sentence(report), report.unit),
        facts=tuple(_facts(report)),
        sections=(
            Section(anchor="verdicts", title="Friction and verdict", parts=tuple(_answer(report, answered, drawn))),
            *([joints] if answered else ()),
            *(topics[name](report, drawn) for name in report.sections if answered or name == "recording"),
            Section(anchor="warnings", title="Warnings", parts=(listed,), folded=True, note=str(len(warnings))),
            Section(
                anchor="words", title="How to read it", parts=(Terms(pairs=tuple(WORDS.items()), words=True),),
                folded=True, on_paper=False,
            ),
            settings_section(report_settings(report), report.command),
            citation_section(),
        ),
    )  # fmt: skip


def _facts(report: LogReport) -> Iterator[tuple[str, str]]:
    log = report.estimate.log
    yield "Robot", log.source.robot
    if log.source.start_s is not None:
        yield "Recorded (UTC)", format_start(log.source.start_s)
    yield "Duration", f"{log.duration_s:.4g} s"
    yield "Rate", f"{log.rate_hz:.4g} Hz"
    yield "Joints", str(len(report.joints))
    yield "Cycles", str(sum(one.friction.cycles for one in report.joints))


def _answer(report: LogReport, answered: list[JointReport], drawn: Drawn) -> Iterator[Part]:
    """Yield the table of the answers, why the other joints have none, and the velocity-torque sheet."""
    if answered:
        caption = "Friction over the whole log with 95 % intervals, and what the nominal model misses"
        yield VERDICT.people(answered, caption=caption, unit=report.unit).filled()
    # Warnings about the replay stand in its section.
    joints = [one.friction for one in report.joints]
    _, physics = physics_of(estimate_notices(report.estimate), joints)
    if physics:
        yield Text(lines=[line.removeprefix(f"{MARK} ") for line in physics], listed=True, tone="unsure")
    without = [in_unit(line, report.unit) for line in reason_lines(joints)]
    if without:
        yield Text(lines=[f"No estimate on {line}." for line in without], tone="off" if answered else "unsure")
    if all(one.friction.reason for one in report.joints):
        yield Text(lines=(RECORD,))
    yield from _pictures(drawn, "verdicts")


def _joint(report: LogReport, one: JointReport) -> Section:
    label, unit, found = joint_label(one.joint, one.name), report.unit, one.discrepancy
    pairs = dict(terms_of(FRICTION, one.friction, unit).pairs)
    if found is not None:
        pairs |= terms_of(JOINT_DIAGNOSIS, found, unit).pairs
        pairs |= {"negligible": negligible_words(found)} if found.negligible else {}
        pairs |= {"unexplained": remainder_words(found)} if found.checks else {}
    if one.replay is not None:
        pairs |= terms_of(JOINT_REPLAY, one.replay, unit).pairs
    own = [notice.message for notice in report_notices(report) if notice.joint == one.joint]
    return Section(
        anchor=f"joint-{one.joint}",
        title=f"Joint {label}",
        # Why there is no estimate stands below the table of the answers.
        note=verdict_word(one)
        if one.friction.reason
        else in_unit(f"{friction_words(one.friction)}; {verdict_word(one)}", unit),
        parts=(
            Terms(pairs=[(name, in_unit(plain_names(text), unit)) for name, text in pairs.items()]),
            *_effects(report, one),
            *([Text(lines=own, listed=True, tone="unsure")] if own else ()),
        ),
        folded=True,
    )


def _effects(report: LogReport, one: JointReport) -> Iterator[Part]:
    """Yield the tables of the diagnosis of a joint that have rows."""
    if one.discrepancy is None:
        return
    rows, joint = effect_rows([one.discrepancy]), f"joint {one.joint}"
    competing = [(row, other) for row in rows for other in row.effect.evidence if other.name != row.effect.name]
    tables = (
        EFFECT.people(rows, caption=f"Missing effects of {joint}, the largest first", unit=report.unit),
        COMPETITOR.people(
            competing,
            caption=f"Effects competing with those of {joint}: from 6 on the evidence against them is strong",
            folded=True,
        ),
        UNTESTABLE.people(
            untestable_rows([one.discrepancy]), caption=f"Effects that this log cannot show on {joint}",
            folded=True, unit=report.unit,
        ),
    )  # fmt: skip
    for table in tables[: 1 if rows else 0]:
        yield _of_one_joint(table)
    undecided = [row for row in rows if row.effect.alternatives]
    if undecided:
        separate = (
            f"To separate {names_of(row.effect, row.joint.effects)}: {decide_words(row.effect)}." for row in undecided
        )
        yield Text(lines=[plain_names(line).replace(" or ", " from ", 1) for line in separate])
    yield from (_of_one_joint(table) for table in tables[1:] if table.rows)


def _of_one_joint(table: Table) -> Table:
    return replace(table, columns=[column for column in table.filled().columns if column.name != "joint"])


def _friction(report: LogReport, drawn: Drawn) -> Section:
    found, settings = report.estimate.friction, report.estimate.settings.friction
    lines = [
        f"Estimator {found.estimator}, {settings.model} model.",
        f"A window of up to {settings.cycles_per_point} cycles moves over the log.",
    ]
    fitted = (one.friction for one in report.joints if not one.friction.reason and one.friction.method == "energy")
    short = [one.joint for one in fitted if one.cycles < 2 * one.window]
    if short:
        lines.append(f"Too few cycles for a change within the log to show: {joints_label(short)}.")
    parts = (Text(lines=lines), *_pictures(drawn, "friction"))
    return Section(anchor="friction", title="Friction over time", parts=parts, folded=True)


def _compensator(report: LogReport, drawn: Drawn) -> Section:
    title = "What a compensator would have done"
    if report.replay is None:
        return Section(anchor="compensator", title=title, parts=_unanswered(report, "replay"), folded=True)
    found = report.replay.replay
    lines = (
        f"Compensator: {in_unit(describe_compensator(found.joints), report.unit)}.",
        f"Assumption {found.counterfactual.name}: {found.counterfactual.assumes}.",
    )
    warnings = notice_lines(notices(found.warnings))
    cautions = [Text(lines=warnings, listed=True, tone="unsure")] if warnings else []
    parts = (Text(lines=lines), *cautions, *_pictures(drawn, "compensator"))
    return Section(anchor="compensator", title=title, parts=parts, folded=True)


def _missing(report: LogReport, drawn: Drawn) -> Section:
    title = "What the model misses"
    if report.diagnosis is None:
        return Section(anchor="diagnosis", title=title, parts=_unanswered(report, "diagnose"), folded=True)
    model = Text(lines=(f"Nominal model: {nominal_model(report.diagnosis.settings.model)}.",))
    rows = effect_rows(report.diagnosis.discrepancy.joints)
    effects = EFFECT.people(rows, caption="Missing effects, the largest of a joint first", unit=report.unit)
    parts = (model, *([effects] if rows else ()), *_pictures(drawn, "diagnosis"))
    return Section(anchor="diagnosis", title=title, parts=parts, folded=True)


def _unanswered(report: LogReport, part: str) -> tuple[Text, ...]:
    why = [one.message for one in report.unanswered if one.part == part]
    return (Text(lines=why or ["No joint has an estimate."], tone="unsure"),)


def _pictures(drawn: Drawn, section: str) -> Iterator[Part]:
    """Yield the figures of a section, and the names of those that found no room."""
    yield from drawn.by_section.get(section, ())
    left_out = drawn.left_out.get(section, ())
    if left_out:
        more = "The command plot draws those of friction and compensator, diagnose those of missing effects"
        yield Text(lines=(f"This page has no room for more figures. {more}: {'; '.join(left_out)}.",))


def _recording(report: LogReport, drawn: Drawn) -> Section:  # noqa: ARG001 - as of the sections with figures
    estimate = report.estimate
    summary = summarize_log(estimate.log, estimate.interaction, estimate.cycles)
    channels = CHANNEL.people(
        estimate.log.source.channels.items(),
        caption="Channels as they are called in the log; {i} is the number of the joint",
        folded=True,
    )
    return Section(
        anchor="recording",
        title="What was recorded",
        folded=any(not one.friction.reason for one in report.joints),
        parts=(
            Terms(pairs=[*_source(summary), *_torque(estimate.interaction.choice, report.unit)]),
            MOTION.people(summary.joints, caption="How the joints moved"),
            channels,
            *_sign(report),
            *data_tables(report.diagnosis),
        ),
    )


def _source(summary: LogSummary) -> Iterator[tuple[str, str]]:
    log, source = summary.log, summary.log.source
    yield "File", source.path
    yield "SHA-256", source.sha256
    yield "Format", f"{source.format}, topic {source.topic}" if source.topic else source.format
    yield "Robot", f"{source.robot}, serial number {source.serial}" if source.serial else source.robot
    yield "Samples", f"{len(log.t)} in {log.duration_s:.6g} s, {log.rate_hz:.6g} Hz"
    yield "Clock", f"{source.clock}, {summary.steps_text}, {summary.clock_text}"
    yield "Repeated", f"{count_of(summary.stale_samples, 'repeated sample')} left out"


def _torque(choice: TorqueChoice, unit: str) -> Iterator[tuple[str, str]]:
    yield "Interaction torque", in_unit("; ".join(filter(None, (choice.formula, choice.reason))), unit)
    yield "Torque source", choice.source
    yield "Driven by", "a hand on the arm" if choice.drive == "hand" else "the robot itself"
    yield "Gravity", choice.gravity
    yield "Inertia", choice.inertia
    model = "" if choice.model_rate_hz is None else f", evaluated at {choice.model_rate_hz:g} Hz"
    yield "Rigid-body model", f"{choice.robot}{model}"
    payload = choice.payload
    yield "Payload", "none" if payload is None else f"{payload[0]:g} kg at {', '.join(f'{x:g}' for x in payload[1:])} m"
    turned = "; turned against the first reading" if choice.sign_turned else ""
    yield "Sign", f"{choice.sign:+d}, {sign_text(choice).removeprefix('sign ')}{turned}"


def _sign(report: LogReport) -> tuple[Table, ...]:
    """Return what the energy of each joint says about the sign of its torque, if that was looked at."""
    choice, names = report.estimate.interaction.choice, report.estimate.log.joint_names
    rows = [(JointName(one.joint, names[one.joint - 1]), one) for one in choice.sign_evidence]
    caption = "Sign of the torque: friction dissipates energy, so the torque goes with the motion"
    return (SIGN.people(rows, caption=caption, folded=True, unit=report.unit),) if rows else ()
