"""LogReport -> one HTML page: verdicts, the recording, friction, the compensator, what is missing, every setting."""

from collections.abc import Iterator

from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.reporting.drift_words import count_of, format_start
from friction_audit.reporting.html.log_figures import COMPENSATOR, FRICTION, MISSING, Draw, Drawn, draw_figures
from friction_audit.reporting.html.log_part import settings_section
from friction_audit.reporting.html.log_tables import (
    TONES,
    channel_table,
    coefficient_table,
    data_tables,
    decision_table,
    effect_table,
    gap_table,
    motion_table,
    replay_table,
    rival_table,
    sign_table,
    untestable_table,
)
from friction_audit.reporting.html.page import (
    Page,
    Part,
    Section,
    Terms,
    Text,
    Verdict,
    Verdicts,
    citation_section,
    render_page,
)
from friction_audit.reporting.html.svg import draw_inline
from friction_audit.reporting.json.report import report_settings
from friction_audit.reporting.log_report import JointReport, LogReport, report_notices
from friction_audit.reporting.log_summary import LogSummary, summarize_log
from friction_audit.reporting.log_words import lead_sentence, verdict_sentence, verdict_word
from friction_audit.reporting.terminal.diagnose import declared_model
from friction_audit.reporting.terminal.estimate import NOTHING, joint_label
from friction_audit.reporting.terminal.plain import log_notices, notice_lines
from friction_audit.reporting.terminal.replay import describe_compensator, shown_joint
from friction_audit.reporting.units import in_unit

NO_FIGURES = Drawn(by_section={}, left_out={})
WORDS = {
    "interaction torque": "F_m, the torque at the joint's torque sensor that drives the joint against friction and "
    "inertia.",
    "energy cycle": "From one moment of rest to the next: no energy is stored in the motion at either end, so that "
    "what was put in is what friction took.",
    "Coulomb, viscous": "Friction that is there at any speed, and friction that grows with speed.",
    "95 % interval": "Holds noise and what differs from stroke to stroke; not errors of the model, such as a wrong "
    "payload.",
    "condition number": "How well the cycles tell the two coefficients apart; from some hundreds on they do not.",
    "nothing missing": "No effect of the catalogue is there that would have been seen: smaller than the detection "
    "limit it may be.",
    "effect named": "The joint does something that inertia, Coulomb and viscous friction do not explain, and the log "
    "tells what.",
    "ambiguous": "Something is missing, and this log does not tell it from something else.",
    "unexplained": "Something is missing that nothing in the catalogue explains.",
    "not testable": "The log lacks the motion that would tell.",
    "data fault": "The data contradict themselves, or a channel is dead, so that nothing may be concluded from them.",
    "failed": "A bug ended the diagnosis of the joint; the other joints are answered.",
    "gap": "Torque that a model leaves unexplained, as root mean square, on cycles that were locked away before "
    "anything was chosen.",
    "floor": "What the noise leaves, below which no model of the motion gets.",
    "removed": "Share of what friction took that the compensator would have given in the person's place.",
    "passive": "The compensated joint never gave out more energy than was put into it.",
}
"""What the words of the page mean."""


def write_log_page(report: LogReport) -> str:
    """Return the page of a log as HTML text, the same bytes for the same result."""
    return render_page(log_page(report))


def log_page(report: LogReport, draw: Draw | None = draw_inline) -> Page:
    """Return what the page of a log is made of.

    Args:
        report: What the log says.
        draw: Draws a figure for the page, or None for none.
    """
    drawn = NO_FIGURES if draw is None else draw_figures(report, draw)
    page = Page(
        title=f"Joint friction: {report.file_name}",
        lead=lead_sentence(report),
        facts=tuple(_facts(report)),
        sections=(
            Section(anchor="verdicts", title="Verdict per joint", parts=(_verdicts(report),)),
            _recording(report),
            _friction(report, drawn),
            _compensator(report, drawn),
            _missing(report, drawn),
            _warnings(report),
            Section(anchor="words", title="How to read it", parts=(Terms(pairs=tuple(WORDS.items())),)),
            settings_section(report_settings(report), report.command),
            citation_section(),
        ),
    )
    in_its_unit: Page = in_unit(page, report.estimate.log.source.torque_unit)
    return in_its_unit


def _facts(report: LogReport) -> Iterator[tuple[str, str]]:
    log = report.estimate.log
    yield "Robot", log.source.robot
    if log.source.start_s is not None:
        yield "Recorded (UTC)", format_start(log.source.start_s)
    yield "Duration", f"{log.duration_s:.4g} s"
    yield "Rate", f"{log.rate_hz:.4g} Hz"
    yield "Joints", str(len(report.joints))
    yield "Cycles", str(sum(one.friction.cycles for one in report.joints))


def _verdicts(report: LogReport) -> Verdicts:
    return Verdicts(verdicts=[_verdict(one) for one in report.joints])


def _verdict(joint: JointReport) -> Verdict:
    word, friction = verdict_word(joint), joint.friction
    name = f"Joint {joint_label(friction.joint, friction.name)}"
    return Verdict(name=name, word=word, tone=TONES[word], sentence=verdict_sentence(joint))


def _recording(report: LogReport) -> Section:
    estimate = report.estimate
    summary = summarize_log(estimate.log, estimate.interaction, estimate.cycles)
    found = notice_lines(log_notices(estimate.log))
    reader: Part = (
        Text(lines=found, listed=True, tone="unsure")
        if found
        else Text(lines=("The reader found nothing wrong with the recording.",))
    )
    return Section(
        anchor="recording",
        title="What was recorded",
        parts=(Terms(pairs=tuple(_source(summary))), reader, motion_table(summary), channel_table(report)),
        sections=(
            Section(
                anchor="torque",
                title="Interaction torque",
                parts=(Terms(pairs=tuple(_torque(estimate.interaction.choice))), *sign_table(report)),
            ),
            *_data_audit(report),
        ),
    )


def _source(summary: LogSummary) -> Iterator[tuple[str, str]]:
    log, source = summary.log, summary.log.source
    yield "File", source.path
    yield "SHA-256", source.sha256
    yield "Format", f"{source.format}, topic {source.topic}" if source.topic else source.format
    yield "Robot", f"{source.robot}, serial number {source.serial}" if source.serial else source.robot
    gaps = f"{count_of(summary.gaps, 'gap')}, the longest {summary.longest_gap_s:.3g} s" if summary.gaps else "no gaps"
    yield "Samples", f"{len(log.t)} in {log.duration_s:.6g} s, {log.rate_hz:.6g} Hz"
    yield "Clock", f"{source.clock}, {summary.jitter}, {gaps}, {summary.clock_check}"
    yield "Repeated", f"{count_of(summary.stale_samples, 'repeated sample')} left out"


def _torque(choice: TorqueChoice) -> Iterator[tuple[str, str]]:
    yield "Formula", f"{choice.formula}; {choice.reason}" if choice.reason else choice.formula
    yield "Source", choice.source
    yield "Driven by", "a hand on the arm" if choice.drive == "hand" else "the robot itself"
    yield "Gravity", choice.gravity
    yield "Inertia", choice.inertia
    model = "" if choice.model_rate_hz is None else f", evaluated at {choice.model_rate_hz:g} Hz"
    yield "Rigid-body model", f"{choice.robot}{model}"
    payload = choice.payload
    yield "Payload", "none" if payload is None else f"{payload[0]:g} kg at {', '.join(f'{x:g}' for x in payload[1:])} m"
    proof = "proved by the energy" if choice.sign_proved else "not proved by the energy"
    turned = "; turned against the first reading" if choice.sign_turned else ""
    yield "Sign", f"{choice.sign:+d}, {proof}{turned}"


def _data_audit(report: LogReport) -> Iterator[Section]:
    tables = tuple(data_tables(report))
    if tables:
        fine = all(table.folded for table in tables)
        lead = (Text(lines=("No limit and no fault was found.",)),) if fine else ()
        yield Section(anchor="data", title="Audit of the data", parts=(*lead, *tables))


def _friction(report: LogReport, drawn: Drawn) -> Section:
    settings, found = report.estimate.settings.friction, report.estimate.friction
    how = (
        f"Estimator {found.estimator}, {settings.model} model; each point of the history is made of the last "
        f"{count_of(settings.cycles_per_point, 'cycle')}."
    )
    parts = (Text(lines=(how,)), coefficient_table(report), *_pictures(drawn, FRICTION))
    return Section(anchor=FRICTION, title="Friction", parts=parts)


def _compensator(report: LogReport, drawn: Drawn) -> Section:
    title = "What a compensator would have done"
    if report.replay is None:
        return Section(anchor=COMPENSATOR, title=title, parts=_unanswered(report, "replay"))
    found = report.replay.replay
    lines = (
        f"Compensator: {describe_compensator(shown_joint(found.joints))}.",
        f"Assumption {found.counterfactual.name}: {found.counterfactual.assumes}.",
    )
    parts = (Text(lines=lines), replay_table(found.joints), *_pictures(drawn, COMPENSATOR))
    return Section(anchor=COMPENSATOR, title=title, parts=parts)


def _missing(report: LogReport, drawn: Drawn) -> Section:
    title = "What the model misses"
    if report.diagnosis is None:
        return Section(anchor=MISSING, title=title, parts=_unanswered(report, "diagnose"))
    joints = report.diagnosis.discrepancy.joints
    parts = (
        Text(lines=(f"Declared model: {declared_model(report.diagnosis.settings.model)}.",)),
        gap_table(joints),
        *effect_table(joints),
        *decision_table(joints),
        *_pictures(drawn, MISSING),
        *rival_table(joints),
        *untestable_table(joints),
    )
    return Section(anchor=MISSING, title=title, parts=parts)


def _unanswered(report: LogReport, part: str) -> tuple[Text, ...]:
    why = [one.message for one in report.unanswered if one.part == part]
    return (Text(lines=why or [NOTHING], tone="unsure"),)


def _pictures(drawn: Drawn, section: str) -> Iterator[Part]:
    """Yield the figures of a section, and the names of those that found no room."""
    yield from drawn.by_section.get(section, ())
    left_out = drawn.left_out.get(section, ())
    if left_out:
        more = "The command plot draws those of friction and compensator, diagnose those of what is missing"
        yield Text(lines=(f"This page has no room for more figures. {more}: {'; '.join(left_out)}.",))


def _warnings(report: LogReport) -> Section:
    read = set(log_notices(report.estimate.log))
    lines = notice_lines(one for one in report_notices(report) if one not in read)
    note = Text(lines=lines, listed=True, tone="unsure") if lines else Text(lines=("There are none.",))
    lead = Text(lines=("What was noticed on the way from the log to these results, beside what the reader found.",))
    return Section(anchor="warnings", title="Warnings", parts=(lead, note))
