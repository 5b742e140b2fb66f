"""BatchSummary -> one HTML page: verdicts, figures, every session, every setting."""

from collections.abc import Iterator, Mapping

from friction_audit.drift.report import ArmDrift
from friction_audit.reporting.batch_drawings import TITLES, draw, page_drawings
from friction_audit.reporting.batch_summary import BatchSummary
from friction_audit.reporting.drift_words import (
    arm_sentence,
    arm_verdict,
    count_of,
    drifting_joints,
    enumerate_words,
    span_of,
)
from friction_audit.reporting.html.batch_tables import (
    TONES,
    coefficient_tables,
    diagnosis_table,
    failed_table,
    joint_tables,
    left_out_table,
    rows_for,
    session_table,
    step_table,
    within_table,
)
from friction_audit.reporting.html.log_part import settings_section
from friction_audit.reporting.html.page import (
    Figure,
    Page,
    Part,
    Section,
    Table,
    Terms,
    Text,
    Verdict,
    Verdicts,
    citation_section,
    render_page,
)

MOST_BYTES = 1_600_000
"""Figures of one page together: a page of many arms shows those that drift, and names the others."""
WORDS = {
    "session": "One recording of one arm. Sessions are numbered from 1 in the order of their starts.",
    "reference": "The sessions that the others are held against: a control chart's normal state.",
    "change": "From the level in the reference to that of the last sessions, with its 95 % interval.",
    "trend": "Robust slope over the sessions, with its 95 % interval.",
    "step": "A change between two sessions. The session named is the first one after it, beside it the range that "
    "holds it with 95 % confidence.",
    "drift": "The change is too large and too steady for chance. All joints of an arm are tested together.",
    "temperature": "It changes together with the temperature, so that drift cannot be told from it.",
    "no drift found": "No proof that nothing changed: what is smaller than the value under \u201cwould show\u201d can "
    "be missed.",
    "would show": "The smallest straight change, start to end, that so many sessions show with 90 % power.",
    "within a session": "Change from the first to the last third of a session, warm-up for one; no part of drift.",
}
"""What the words of the page mean."""
NOTHING_YET: Mapping[str, Figure] = {}


def write_page(summary: BatchSummary, drawn: Mapping[str, Figure] = NOTHING_YET) -> str:
    """Return the page of a batch as HTML text, the same bytes for the same batch.

    Args:
        summary: The batch.
        drawn: Figures that somebody has drawn, by their anchors; the others are drawn here.
    """
    return render_page(batch_page(summary, drawn))


def batch_page(summary: BatchSummary, drawn: Mapping[str, Figure] = NOTHING_YET) -> Page:
    """Return what the page of a batch is made of; another page may take sections from it."""
    return Page(
        title="Friction over sessions",
        lead=_lead(summary),
        facts=_facts(summary),
        sections=(
            _verdict_section(summary),
            *_arm_sections(summary, drawn),
            *_failed_section(summary),
            Section(anchor="words", title="How to read it", parts=(Terms(pairs=tuple(WORDS.items())),)),
            settings_section(summary.settings, summary.command),
            citation_section(),
        ),
    )


def _lead(summary: BatchSummary) -> str:
    drifting = [arm for arm in summary.arms if arm.drift]
    if not summary.arms:
        return "No session could be read, so that nothing can be said of drift."
    if not drifting:
        arms = "the arm" if len(summary.arms) == 1 else f"any of {len(summary.arms)} arms"
        return f"No drift of the friction was found on {arms}."
    return "; ".join(f"{arm.robot}: {_drift_words(arm)}" for arm in drifting) + "."


def _drift_words(arm: ArmDrift) -> str:
    joints = drifting_joints(arm)
    word = "joint" if len(joints) == 1 else "joints"
    return f"friction drifts on {word} {enumerate_words(joints)}" if joints else "friction drifts"


def _facts(summary: BatchSummary) -> tuple[tuple[str, str], ...]:
    facts = [("Sessions", str(len(summary.sessions))), ("Arms", str(len(summary.arms)))]
    span = span_of(summary.sessions)
    facts += [("Recorded (UTC)", span)] if span else []
    facts += [("Files that failed", str(len(summary.failed)))]
    return tuple(facts)


def _verdict_section(summary: BatchSummary) -> Section:
    verdicts = Verdicts(verdicts=[_verdict(arm) for arm in summary.arms])
    limits = [f"Limit exceeded: {one}" for one in summary.exceeded] + [
        f"Cannot tell: {one}" for one in summary.cannot_tell
    ]
    parts = (Text(lines=limits, listed=True, tone="alert"),) if limits else ()
    return Section(anchor="verdicts", title="Verdicts", parts=(verdicts, *parts))


def _verdict(arm: ArmDrift) -> Verdict:
    word = arm_verdict(arm)
    return Verdict(name=arm.robot, word=word, tone=TONES[word], sentence=arm_sentence(arm))


def _arm_sections(summary: BatchSummary, drawn: Mapping[str, Figure]) -> Iterator[Section]:
    """Yield a section per arm; figures first of the arms that drift, as long as there is room."""
    pictures, most = _pictures(summary.arms, drawn), rows_for(summary.arms)
    for number, arm in enumerate(summary.arms, start=1):
        yield _arm_section(arm, f"arm-{number}", pictures.get(number, ()), most)


def _pictures(arms: tuple[ArmDrift, ...], drawn: Mapping[str, Figure]) -> dict[int, tuple[Figure, ...]]:
    """Return the figures of each arm, by its number, as many arms as there is room for."""
    order = sorted(range(len(arms)), key=lambda k: not arms[k].drift)
    found: dict[int, tuple[Figure, ...]] = {}
    left = MOST_BYTES
    for k in order:
        figures = tuple(_figures(arms[k], f"arm-{k + 1}", drawn))
        left -= sum(figure.picture.size for figure in figures)
        if left < 0 and found:
            break
        found[k + 1] = figures
    return found


def _figures(arm: ArmDrift, anchor: str, drawn: Mapping[str, Figure]) -> Iterator[Figure]:
    """Yield the figures of an arm."""
    for kind in TITLES:
        for drawing in page_drawings(arm, anchor, kind):
            figure = drawn.get(drawing.anchor) or draw(drawing).figure
            if figure is not None:
                yield figure


def _arm_section(arm: ArmDrift, anchor: str, figures: tuple[Figure, ...], most: int) -> Section:
    span = span_of(arm.sessions)
    counts = f"{count_of(len(arm.sessions), 'session')}{f', {span}' if span else ''}, {len(arm.compared)} compared."
    notes: list[Part] = [Text(lines=arm.warnings, listed=True, tone="unsure")] if arm.warnings else []
    return Section(
        anchor=anchor,
        title=arm.robot,
        parts=(Text(lines=(counts,)), *notes),
        sections=(
            Section(anchor=f"{anchor}-joints", title="Joints", parts=_joints(arm)),
            Section(anchor=f"{anchor}-figures", title="Figures", parts=figures or (_no_room(arm),)),
            Section(anchor=f"{anchor}-within", title="Within a session", parts=(within_table(arm),)),
            *_diagnosis(arm, anchor),
            Section(
                anchor=f"{anchor}-sessions",
                title="Sessions",
                parts=(*left_out_table(arm), session_table(arm, most), *coefficient_tables(arm, most)),
            ),
        ),
    )


def _joints(arm: ArmDrift) -> tuple[Table, ...]:
    """Return verdicts, steps, and the numbers behind them."""
    verdicts, numbers = joint_tables(arm)
    return verdicts, *step_table(arm), numbers


def _no_room(arm: ArmDrift) -> Text:
    return Text(lines=(f"This page has no room for more figures; those of {arm.robot} are in files beside it.",))


def _diagnosis(arm: ArmDrift, anchor: str) -> tuple[Section, ...]:
    table = diagnosis_table(arm)
    return (Section(anchor=f"{anchor}-diagnosis", title="What the model misses", parts=(table,)),) if table else ()


def _failed_section(summary: BatchSummary) -> tuple[Section, ...]:
    if not summary.failed:
        return ()
    lead = Text(lines=("These files gave no session. The others are not touched by it.",))
    return (Section(anchor="failed", title="Files that failed", parts=(lead, failed_table(summary.failed))),)
