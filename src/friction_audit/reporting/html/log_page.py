"""LogReport -> one HTML page: the answer and the velocity-torque sheet first, details by joint and by topic folded."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from types import SimpleNamespace

import numpy as np

from friction_audit.effects.registry import effect_of, motion_to_decide
from friction_audit.parallel import in_processes, workers_for
from friction_audit.reporting import diagnosis_tables as tables, diagnosis_words as words, notices, report as reports
from friction_audit.reporting.documents import write_document
from friction_audit.reporting.estimate import FRICTION
from friction_audit.reporting.figures import FigureKind, figures_of
from friction_audit.reporting.figures.panels import label_in_unit
from friction_audit.reporting.html import page as html
from friction_audit.reporting.info import MOTION, facts_of, summarize_log
from friction_audit.reporting.replay import JOINT_REPLAY, describe_compensator
from friction_audit.reporting.table import Column, Record, joint_column
from friction_audit.reporting.words import MARK, NOTHING, format_start, in_unit, joint_label, joints_label

FIRST = "velocity-torque"  # stands next to the answer
SECTION_OF = {"estimate": "friction", "replay": "compensator", "diagnosis": "diagnosis"}  # by the result that is drawn
CAPTIONS = notices.sentences()["captions"]  # of the figures that stand on a page, by their kind
LOG_FIGURES = tuple(kind for kind in figures_of(*SECTION_OF) if kind.name in CAPTIONS)
PLACES = {kind: "verdicts" if kind.name == FIRST else SECTION_OF[kind.result] for kind in LOG_FIGURES}
CLOUD = 60  # dots in a panel from which on they are an image: text would be larger than the rest of the page
COARSE_PT = 0.5  # invisible deviation of a drawn line

Drawn = Mapping[str, list[html.Figure]]  # the figures of a page by section, in order
CHANNEL = Record(
    Column("channel", str, get="0", on="p"), Column("name", str, get="1", title="name in the log", code=True, on="p")
)
SIGN = Record(
    joint_column("0"),
    Column("energy", str, get="1.verdict", on="p"),
    Column("moving", float, get="1.moving_s", unit="s", title="moving, slowly too", on="p"),
    Column("path", float, get="1.path_rad", unit="rad", on="p"),
    Column("with_motion", get="1.against_motion_nm", unit="N m", title="torque with the motion", on="p"),
    Column("error", get="1.standard_error_nm", form=".2g", unit="N m", title="standard error", on="p"),
)


def log_page(report: reports.LogReport, *, figures: bool = True) -> html.Page:
    """Return what the page of a log is made of, with figures or without."""
    drawn = draw_figures(report) if figures else {}
    log, source = report.estimate.log, report.estimate.log.source
    answered = [one for one in report.joints if not one.friction.reason or one.answer]
    warnings = notices.notice_lines(reports.report_notices(report))
    listed = html.Text(warnings or ("There are none.",), listed=bool(warnings), tone="unsure" if warnings else "")
    joints = html.Section("joints", "Joints", sections=[_joint(report, one) for one in answered], on_paper=False)
    known = any(not one.friction.reason for one in report.joints)
    facts = {
        "Robot": source.robot, "Recorded (UTC)": format_start(source.start_s).removeprefix(NOTHING),
        "Duration": f"{log.duration_s:.4g} s", "Rate": f"{log.rate_hz:.4g} Hz", "Joints": str(len(report.joints)),
        "Cycles": str(sum(one.friction.cycles for one in report.joints)),
    }  # fmt: skip
    settings = reports.report_settings(report)
    topics = {name: TOPICS[name] for name in report.sections if answered or name == "recording"}
    sections = (
        html.Section("verdicts", "Friction and verdict", [*_answer(report, answered, drawn)]),
        joints,
        *(
            html.Section(name, title, (*parts(report), *drawn.get(name, ())), folded=known or name != "recording")
            for name, (title, parts) in topics.items()
        ),
        html.Section("warnings", "Warnings", (listed,), folded=True, note=str(len(warnings))),
        *html.closing_sections(notices.sentences()["log_page"], settings, report.command, paper=False),
    )
    lead = in_unit(reports.lead_sentence(report), report.unit)
    return html.Page(f"Joint friction: {source.path}", lead, facts, sections)


def _answer(report: reports.LogReport, answered: list[reports.JointReport], drawn: Drawn) -> Iterator[html.Part]:
    """Yield the table of the answers, why the other joints have none, and the velocity-torque sheet."""
    intervals = "no intervals" if report.estimate.friction.estimator == "paper" else "95 % intervals"
    caption = f"Friction over the whole log with {intervals}, and what the nominal model misses"
    yield reports.VERDICT.people(answered, caption=caption, unit=report.unit).filled()
    # Warnings about the replay stand in its section.
    joints = [one.friction for one in report.joints]
    _, physics = notices.physics_of(notices.estimate_notices(report.estimate), joints)
    yield html.Text([line.removeprefix(f"{MARK} ") for line in physics], listed=True, tone="unsure")
    if regressed := [one.joint for one in joints if one.method != "energy" and not one.reason]:
        text = f"From torque regression, as too few energy cycles count: {joints_label(regressed)}."
        yield html.Text(lines=(text,), tone="unsure")
    without = [f"No estimate on {in_unit(line, report.unit)}." for line in notices.reason_lines(joints)]
    yield html.Text(without, tone="off" if answered else "unsure")
    if all(one.reason for one in joints):
        yield html.Text((notices.sentences()["lines"]["record"],))
    yield from drawn.get("verdicts", ())


def _joint(report: reports.LogReport, one: reports.JointReport) -> html.Section:
    label, unit = joint_label(one.joint, one.name), report.unit
    rows = ((FRICTION, one.friction), (tables.JOINT_DIAGNOSIS, one.diagnosis), (JOINT_REPLAY, one.replay))
    filled = [(table.people([row], unit=unit).filled(without="joint"), row) for table, row in rows if row is not None]
    pairs = {column.head(unit): table.text(column, row) for table, row in filled for column in table.columns}
    own = list(dict.fromkeys(notice.message for notice in reports.report_notices(report) if notice.joint == one.joint))
    terms = html.Terms([(name, in_unit(words.plain_names(text), unit)) for name, text in pairs.items()])
    parts = (terms, *_effects(report, one), html.Text(own, listed=True, tone="unsure"))
    note = in_unit(reports.joint_words(one), unit)
    return html.Section(f"joint-{one.joint}", f"Joint {label}", parts, folded=True, note=note)


def _effects(report: reports.LogReport, one: reports.JointReport) -> Iterator[html.Part]:
    if one.diagnosis is None:
        return
    rows, joint, unit = tables.effect_rows([one.diagnosis]), f"joint {one.joint}", report.unit
    caption = f"Missing effects of {joint}, the largest first"
    yield tables.EFFECT.people(rows, caption=caption, unit=unit).filled(without="joint")
    unsure = [row for row in rows if row.effect.alternatives]
    separate = [f"{row.names}: {motion_to_decide(row.effect.name, row.effect.alternatives)}." for row in unsure]
    yield html.Text([f"To separate {words.plain_names(line)}".replace(" or ", " from ", 1) for line in separate])
    recorders = {row.effect.label: effect_of(row.effect.name).recorder for row in rows}
    lines = [f"{label}: {text}." for label, text in recorders.items() if text]
    if one.diagnosis.verdict != "adequate" and (lost := words.lost_in_noise(one.diagnosis)):
        lines.append(f"{lost[:1].upper()}{lost[1:]}.")
    yield html.Text(lines)
    competing = [(row, other) for row in rows for other in row.effect.evidence]
    caption = f"Effects competing with those of {joint}: from 6 on the evidence against them is strong"
    yield tables.COMPETITOR.people(competing, caption=caption, unit=unit, folded=True).filled(without="joint")
    untestable, caption = tables.untestable_rows(one.diagnosis), f"Effects that this log cannot show on {joint}"
    yield tables.UNTESTABLE.people(untestable, caption=caption, unit=unit, folded=True).filled(without="joint")


def _friction(report: reports.LogReport) -> Iterator[html.Part]:
    found, settings = report.estimate.friction, report.estimate.settings.friction
    lines = [
        f"Estimator {found.estimator}, {settings.model} model.",
        f"A window of up to {settings.cycles_per_point} cycles moves over the log.",
    ]
    fitted = (one.friction for one in report.joints if not one.friction.reason and one.friction.method == "energy")
    if short := [one.joint for one in fitted if one.cycles < 2 * one.window]:
        lines.append(f"Too few cycles for a change within the log to show: {joints_label(short)}.")
    yield html.Text(lines)


def _compensator(report: reports.LogReport) -> Iterator[html.Part]:
    if report.replay is None:
        yield _unanswered(report, "replay")
        return
    found = report.replay.replay
    compensator = f"Compensator: {in_unit(describe_compensator(found.joints), report.unit)}."
    assumption = found.counterfactual
    yield html.Text((compensator, f"Assumption {assumption.code}: {notices.sentence_of(assumption)}."))
    yield html.Text(notices.notice_lines(notices.notices(found.warnings)), listed=True, tone="unsure")


def _missing(report: reports.LogReport) -> Iterator[html.Part]:
    if report.diagnosis is None:
        yield _unanswered(report, "diagnose")
        return
    yield html.Text((f"Nominal model: {words.nominal_model(report.diagnosis.settings.model)}.",))
    rows = tables.effect_rows(report.diagnosis.joints)
    yield tables.EFFECT.people(rows, caption="Missing effects, the largest of a joint first", unit=report.unit)


def _unanswered(report: reports.LogReport, part: str) -> html.Text:
    why = [one.message for one in report.unanswered if one.part == part]
    return html.Text(why or ["No joint has an estimate."], tone="unsure")


def _recording(report: reports.LogReport) -> Iterator[html.Part]:
    estimate, unit, log = report.estimate, report.unit, report.estimate.log
    summary, choice = summarize_log(log, estimate.interaction, estimate.cycles), estimate.interaction.choice
    source = {"file": log.source.path, "SHA-256": log.source.sha256, "serial number": log.source.serial}
    facts = (pair for pair in facts_of(summary) if pair[0] != "channel")
    pairs = [*source.items(), *facts, ("torque source", notices.text_of(choice.reason))]
    yield html.Terms([(name, in_unit(text, unit)) for name, text in pairs if text])
    yield MOTION.people(summary.joints, caption="How the joints moved")
    caption = "Channels as they are called in the log; {i} is the number of the joint"
    yield CHANNEL.people(log.source.channels.items(), caption=caption, folded=True)
    of_log = [SimpleNamespace(joint=number, name=name) for number, name in enumerate(log.joint_names, start=1)]
    signs = [(of_log[one.joint - 1], one) for one in choice.sign_evidence]
    caption = "Sign of the torque: friction dissipates energy, so the torque goes with the motion"
    yield SIGN.people(signs, caption=caption, folded=True, unit=unit)
    joints = () if report.diagnosis is None else report.diagnosis.joints
    checks = [(joint, finding) for joint in joints for finding in joint.findings]
    bad = [row for row in checks if row[1].verdict != "fine"]
    yield tables.FINDING.people(bad, caption="Limits and faults of the data", folded=True)
    yield tables.FINDING.people(checks, caption="Every check of the data", folded=True)


# Sections that can be left out.
TOPICS: Mapping[str, tuple[str, Callable[[reports.LogReport], Iterator[html.Part]]]] = {
    "friction": ("Friction over time", _friction),
    "diagnosis": ("What the model misses", _missing),
    "compensator": ("What a compensator would have done", _compensator),
    "recording": ("What was recorded", _recording),
}
WRITERS: Mapping[str, Callable[[reports.LogReport], bytes]] = {  # what is in a file of a format
    "html": lambda report: html.render_page(log_page(report)).encode(),
    "pdf": lambda report: html.write_pdf(log_page(report)),
    "markdown": lambda report: html.write_markdown(log_page(report, figures=False)).encode(),
    "json": lambda report: write_document(reports.REPORT.json(report, report.unit)).encode(),
}


@lru_cache(maxsize=1)  # a page and its PDF have the same figures
def draw_figures(report: reports.LogReport) -> Drawn:
    """Draw the figures of the sections asked for, all kinds of the first joints before those of the next."""
    from friction_audit.reporting.figures.style import load_matplotlib

    shown: dict[FigureKind, set[int]] = {}
    for kind in LOG_FIGURES:
        result = getattr(report, kind.result)
        if result is not None and PLACES[kind] in ("verdicts", *report.sections):
            layout = kind.layout()
            shown[kind] = {one.joint for one in layout.joints(result) if layout.has(result, one)}
    every = [one for one in report.joints if any(one.joint in numbers for numbers in shown.values())]
    sheets = [
        (kind, joints, f"{kind.title}{which}")
        for own, which in html.sheets_of(every)
        for kind, numbers in shown.items()
        if (joints := tuple(one for one in own if one.joint in numbers))
    ]
    drawn: dict[str, list[html.Figure]] = defaultdict(list)
    load_matplotlib(["svg", "png"] if sheets else [])  # once, and not by every copy
    work = in_processes(lambda k: _figure(report, *sheets[k]), len(sheets), workers_for(len(sheets)))
    for (kind, _, _), figure in zip(sheets, work, strict=True):
        drawn[PLACES[kind]].append(figure)
    return drawn


def _figure(
    report: reports.LogReport, kind: FigureKind, joints: tuple[reports.JointReport, ...], title: str
) -> html.Figure:
    numbers = tuple(one.joint for one in joints)
    drawing = label_in_unit(kind.draw(getattr(report, kind.result), numbers), report.unit)
    for line in (line for axes in drawing.axes for line in axes.lines):
        # Clouds of dots become images, and of curves what is visible is left.
        line.set_rasterized(line.get_linestyle() == "None" and np.size(line.get_xdata()) > CLOUD)
        line.get_path().simplify_threshold = COARSE_PT
    every = "; ".join(f"joint {joint_label(one.joint, one.name)}: {reports.joint_words(one)}" for one in joints)
    about = in_unit(f"{title}. {every}.", report.unit)
    caption = CAPTIONS[kind.name]
    return html.draw_inline(drawing, f"{kind.name}-{numbers[0]}", title=title, caption=caption, description=about)
