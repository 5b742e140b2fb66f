"""LogReport -> one HTML page: verdicts, the recording, friction, the compensator, missing effects, every setting."""

from collections.abc import Iterator

from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.reporting.diagnosis import data_tables, page_tables
from friction_audit.reporting.diagnosis_tables import TONES
from friction_audit.reporting.diagnosis_words import nominal_model
from friction_audit.reporting.estimate import FRICTION as FRICTION_RECORD
from friction_audit.reporting.estimate import sign_text
from friction_audit.reporting.html.log_figures import COMPENSATOR, FRICTION, MISSING, Drawn, draw_figures
from friction_audit.reporting.html.page import (
    Page,
    Part,
    Section,
    Terms,
    Text,
    Verdict,
    Verdicts,
    citation_section,
    settings_section,
)
from friction_audit.reporting.info import MOTION, LogSummary, summarize_log
from friction_audit.reporting.notices import log_notices, notice_lines
from friction_audit.reporting.replay import JOINT_REPLAY, describe_compensator
from friction_audit.reporting.report import (
    ESTIMATED,
    NO_ESTIMATE,
    LogReport,
    lead_sentence,
    report_notices,
    report_settings,
    verdict_sentence,
    verdict_word,
)
from friction_audit.reporting.table import Column, JointName, Record, Table, joint_column
from friction_audit.reporting.words import NOTHING, count_of, format_start, in_unit, joint_label

NO_FIGURES = Drawn(by_section={}, left_out={})
WORDS = {
    "interaction torque": "F_m, the torque at the joint's torque sensor that drives the joint against friction and "
    "inertia.",
    "energy cycle": "From one moment of rest to the next: no energy is stored in the motion at either end, so that "
    "the energy put in is the energy that friction dissipated.",
    "Coulomb, viscous": "Friction that does not depend on the speed, and friction that grows with it.",
    "95 % interval": "Holds noise and the differences between strokes; not errors of the model, such as a wrong "
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
    "residual RMS": "Torque that a model leaves unexplained, as root mean square; each cycle is held out once, in five "
    "folds.",
    "noise floor": "Residual RMS of the noise alone; no model of the motion gets below it.",
    "share explained": "Share of the way from the residual RMS of the nominal model to the noise floor.",
    "size": "RMS of the torque of an effect, free of what the nominal model fits of it. Major from 10 % of the joint's "
    "friction on; negligible below 1 %, listed apart.",
    "chosen in folds": "Selections, each without a fifth of the cycles, that chose the effect.",
    "removed": "Share of the energy put in that the compensator would have removed; energy given out counts as left.",
    "passive": "The compensated joint never gave out more energy than was put into it.",
}
VERDICT_TONES = {**TONES, NO_ESTIMATE: "off", ESTIMATED: "fine"}
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
    return Page(
        title=f"Joint friction: {report.file_name}",
        lead=in_unit(lead_sentence(report), report.unit),
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
    return Verdicts(
        verdicts=[
            Verdict(
                name=f"Joint {joint_label(one.joint, one.name)}",
                word=verdict_word(one),
                tone=VERDICT_TONES[verdict_word(one)],
                sentence=in_unit(verdict_sentence(one), report.unit),
            )
            for one in report.joints
        ]
    )


def _recording(report: LogReport) -> Section:
    estimate = report.estimate
    summary = summarize_log(estimate.log, estimate.interaction, estimate.cycles)
    found = notice_lines(log_notices(estimate.log))
    fine = Text(lines=("The reader found nothing wrong with the recording.",))
    channels = CHANNEL.people(
        estimate.log.source.channels.items(),
        caption="Channels as they are called in the log; {i} is the number of the joint",
        folded=True,
    )
    return Section(
        anchor="recording",
        title="What was recorded",
        parts=(
            Terms(pairs=tuple(_source(summary))),
            Text(lines=found, listed=True, tone="unsure") if found else fine,
            MOTION.people(summary.joints, caption="How the joints moved"),
            channels,
        ),
        sections=(
            Section(
                anchor="torque",
                title="Interaction torque",
                parts=(Terms(pairs=tuple(_torque(estimate.interaction.choice, report.unit))), *_sign(report)),
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
    yield "Samples", f"{len(log.t)} in {log.duration_s:.6g} s, {log.rate_hz:.6g} Hz"
    yield "Clock", f"{source.clock}, {summary.steps_text}, {summary.clock_text}"
    yield "Repeated", f"{count_of(summary.stale_samples, 'repeated sample')} left out"


def _torque(choice: TorqueChoice, unit: str) -> Iterator[tuple[str, str]]:
    yield "Formula", in_unit(f"{choice.formula}; {choice.reason}" if choice.reason else choice.formula, unit)
    yield "Source", choice.source
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


def _data_audit(report: LogReport) -> Iterator[Section]:
    tables = data_tables(report.diagnosis)
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
    caption = "Coefficients over the whole log with 95 % intervals, and a regression of the torque for comparison"
    table = FRICTION_RECORD.people(found.joints, caption=caption, unit=report.unit).filled()
    return Section(anchor=FRICTION, title="Friction", parts=(Text(lines=(how,)), table, *_pictures(drawn, FRICTION)))


def _compensator(report: LogReport, drawn: Drawn) -> Section:
    title = "What a compensator would have done"
    if report.replay is None:
        return Section(anchor=COMPENSATOR, title=title, parts=_unanswered(report, "replay"))
    found = report.replay.replay
    lines = (
        f"Compensator: {in_unit(describe_compensator(found.joints), report.unit)}.",
        f"Assumption {found.counterfactual.name}: {found.counterfactual.assumes}.",
    )
    caption = "Energy and torque of the person without the compensator and with it"
    table = JOINT_REPLAY.people(found.joints, caption=caption, unit=report.unit).filled()
    return Section(anchor=COMPENSATOR, title=title, parts=(Text(lines=lines), table, *_pictures(drawn, COMPENSATOR)))


def _missing(report: LogReport, drawn: Drawn) -> Section:
    title = "What the model misses"
    if report.diagnosis is None:
        return Section(anchor=MISSING, title=title, parts=_unanswered(report, "diagnose"))
    model = Text(lines=(f"Nominal model: {nominal_model(report.diagnosis.settings.model)}.",))
    tables = page_tables(report.diagnosis)
    shown, folded = ([table for table in tables if table.folded is later] for later in (False, True))
    return Section(anchor=MISSING, title=title, parts=(model, *shown, *_pictures(drawn, MISSING), *folded))


def _unanswered(report: LogReport, part: str) -> tuple[Text, ...]:
    why = [one.message for one in report.unanswered if one.part == part]
    return (Text(lines=why or [NOTHING], tone="unsure"),)


def _pictures(drawn: Drawn, section: str) -> Iterator[Part]:
    """Yield the figures of a section, and the names of those that found no room."""
    yield from drawn.by_section.get(section, ())
    left_out = drawn.left_out.get(section, ())
    if left_out:
        more = "The command plot draws those of friction and compensator, diagnose those of missing effects"
        yield Text(lines=(f"This page has no room for more figures. {more}: {'; '.join(left_out)}.",))


def _warnings(report: LogReport) -> Section:
    read = set(log_notices(report.estimate.log))
    lines = notice_lines(one for one in report_notices(report) if one not in read)
    note = Text(lines=lines, listed=True, tone="unsure") if lines else Text(lines=("There are none.",))
    lead = Text(
        lines=("What was noticed on the way from the log to these results, in addition to the reader's findings.",)
    )
    return Section(anchor="warnings", title="Warnings", parts=(lead, note))
