"""BatchSummary -> one HTML page: verdicts, figures, every session, every setting."""

from collections.abc import Iterator, Mapping

from friction_audit.drift.report import ArmDrift
from friction_audit.reporting import drift_words
from friction_audit.reporting.batch_drawings import draw, page_drawings
from friction_audit.reporting.drift import (
    ARM,
    COEFFICIENT,
    DIAGNOSED,
    FAILED,
    STEPS,
    BatchSummary,
    CoefficientRow,
    DiagnosisRow,
    StepRow,
    coefficient_rows,
)
from friction_audit.reporting.drift_sessions import LEFT_OUT, SESSION_NUMBER, SHOWN, SessionRow, coefficient_column
from friction_audit.reporting.figures.registry import figures_of
from friction_audit.reporting.html import page as html
from friction_audit.reporting.table import Record, Table
from friction_audit.reporting.words import count_of, enumerate_words, joints_label

# Figures of one page together: a page of many arms shows those that drift, and names the others. [bytes]
MOST_BYTES = 1_600_000
# Joints side by side in a table of coefficients; more make another table.
ACROSS = 7
# Coefficients that a page lists; all of them are in the file of sessions.
MOST_CELLS = 12_000
WORDS = {
    "session": "One recording of one arm. Sessions are numbered from 1 in the order of their starts.",
    "reference": "The sessions that the others are compared with: a control chart's normal state.",
    "change": "From the level in the reference to that of the last sessions, with its 95 % interval.",
    "trend": "Robust slope over the sessions, with its 95 % interval.",
    "step": "A change between two sessions. The session named is the first one after it; the range in brackets holds "
    "it with 95 % confidence.",
    "drift": "The change is too large and too steady for chance. All joints of an arm are tested together.",
    "temperature": "It changes together with the temperature: drift and temperature cannot be separated.",
    "no drift found": "A change smaller than the minimum detectable one can be missed.",
    "minimum detectable": "The smallest straight change, start to end, that so many sessions detect with 90 % power.",
    "within a session": "Change from the first to the last third of a session, such as warm-up; no part of drift.",
}
"""What the words of the page mean."""


def write_page(summary: BatchSummary, drawn: Mapping[str, html.Figure] | None = None) -> str:
    """Return the page of a batch as HTML text, the same bytes for the same batch.

    Args:
        summary: The batch.
        drawn: Figures that are drawn already, by their anchors; the others are drawn here.
    """
    page = html.Page(
        title="Friction over sessions",
        lead=_lead(summary),
        facts=_facts(summary),
        sections=(
            _verdict_section(summary),
            *_arm_sections(summary, drawn or {}),
            *_failed_section(summary),
            html.Section(
                anchor="words",
                title="How to read it",
                parts=(html.Terms(pairs=tuple(WORDS.items()), words=True),),
                folded=True,
            ),
            html.settings_section(summary.settings, summary.command),
            html.citation_section(),
        ),
    )
    return html.render_page(page)


def _lead(summary: BatchSummary) -> str:
    if not summary.arms:
        return "No session could be read: no statement on drift is possible."
    drifting, arms = [arm for arm in summary.arms if arm.drift], count_of(len(summary.arms), "arm")
    if len(drifting) > 1:
        return f"Friction drifts on {len(drifting)} of {arms}: {enumerate_words(arm.robot for arm in drifting)}."
    if drifting:
        return f"{drifting[0].robot}: {drift_words.arm_sentence(drifting[0])}."
    return f"No drift of the friction was found on {arms}."


def _facts(summary: BatchSummary) -> tuple[tuple[str, str], ...]:
    span = drift_words.span_of(summary.sessions)
    return (
        ("Sessions", str(len(summary.sessions))),
        ("Arms", str(len(summary.arms))),
        *([("Recorded (UTC)", span)] if span else []),
        ("Files that failed", str(len(summary.failed))),
    )


def _verdict_section(summary: BatchSummary) -> html.Section:
    verdicts = ARM.people(summary.arms, caption="Drift of each arm")
    limits = [f"Limit exceeded: {one}" for one in summary.exceeded]
    limits += [f"Cannot test: {one}" for one in summary.cannot_tell]
    parts = (html.Text(lines=limits, listed=True, tone="alert"),) if limits else ()
    return html.Section(anchor="verdicts", title="Verdicts", parts=(verdicts, *parts))


def _arm_sections(summary: BatchSummary, drawn: Mapping[str, html.Figure]) -> Iterator[html.Section]:
    """Yield a section per arm; figures first of the arms that drift, as long as there is room."""
    pictures = _pictures(summary.arms, drawn)
    cells = sum(len(drift_words.UNITS) * max(len(arm.joints), 1) for arm in summary.arms)
    most = max(1, MOST_CELLS // max(cells, 1))
    for number, arm in enumerate(summary.arms, start=1):
        yield _arm_section(arm, f"arm-{number}", pictures.get(number, ()), most)


def _pictures(arms: tuple[ArmDrift, ...], drawn: Mapping[str, html.Figure]) -> dict[int, tuple[html.Figure, ...]]:
    """Return the figures of each arm, by its number, as many arms as there is room for."""
    found: dict[int, tuple[html.Figure, ...]] = {}
    left = MOST_BYTES
    for k in sorted(range(len(arms)), key=lambda k: not arms[k].drift):
        drawings = (one for kind in figures_of("drift") for one in page_drawings(arms[k], f"arm-{k + 1}", kind))
        every = (drawn.get(one.anchor) or draw(one).figure for one in drawings)
        figures = tuple(figure for figure in every if figure is not None)
        left -= sum(len(figure.svg) for figure in figures)
        if left < 0 and found:
            break
        found[k + 1] = figures
    return found


def _arm_section(arm: ArmDrift, anchor: str, figures: tuple[html.Figure, ...], most: int) -> html.Section:
    notes: list[html.Part] = [html.Text(lines=arm.warnings, listed=True, tone="unsure")] if arm.warnings else []
    no_room = html.Text(
        lines=(f"This page has no room for more figures; those of {arm.robot} are in files next to it.",)
    )
    rows = coefficient_rows(arm)
    within = COEFFICIENT.people(
        rows,
        "w",
        caption="Kept apart from drift: the change from the first to the last third of a session, and in how many "
        "sessions it is significant; the change with temperature that was taken out, and the temperature of the "
        "comparison; the scatter between sessions",
    ).filled()
    return html.Section(
        anchor=anchor,
        title=arm.robot,
        parts=(html.Text(lines=(f"{drift_words.sessions_text(arm)}.",)), *notes),
        sections=(
            html.Section(anchor=f"{anchor}-joints", title="Joints", parts=tuple(_joint_tables(arm, rows))),
            html.Section(anchor=f"{anchor}-figures", title="Figures", parts=figures or (no_room,)),
            html.Section(anchor=f"{anchor}-within", title="Within a session", parts=(within,)),
            *_diagnosis(arm, anchor),
            html.Section(anchor=f"{anchor}-sessions", title="Sessions", parts=tuple(_session_tables(arm, most))),
        ),
    )


def _joint_tables(arm: ArmDrift, rows: list[CoefficientRow]) -> Iterator[Table]:
    """Yield verdicts, steps, and the numbers that they rest on."""
    yield COEFFICIENT.people(
        rows, caption="Change of each coefficient from the reference to the last sessions; intervals are 95 %"
    )
    steps = [
        StepRow(row.joint, row.found, change, arm.sessions[change.session].start_s)
        for row in rows
        for change in row.found.change_points
    ]
    if steps:
        after = "the first session after each (with the range that holds it with 95 % confidence)"
        yield STEPS.people(steps, caption=f"Steps: {after}, and the levels")
    yield COEFFICIENT.people(rows, "n", caption="Levels, trends and control charts in numbers", folded=True)


def _diagnosis(arm: ArmDrift, anchor: str) -> Iterator[html.Section]:
    """Yield how often each effect was found on each joint, if the sessions were diagnosed."""
    rows = []
    for joint in arm.joints:
        own = [one for session in arm.sessions for one in session.joints if one.joint == joint.joint and one.verdict]
        verdicts = [(one.verdict or "").replace("_", " ") for one in own]
        if own:
            rows.append(DiagnosisRow(joint, verdicts, [effect for one in own for effect in one.effects]))
    if rows:
        caption = "Verdicts and effects of the diagnosis, with the number of sessions"
        table = DIAGNOSED.people(rows, caption=caption)
        yield html.Section(anchor=f"{anchor}-diagnosis", title="What the model misses", parts=(table,))


def _session_tables(arm: ArmDrift, most: int) -> Iterator[Table]:
    """Yield the sessions that were not compared, the last ``most`` sessions, and their coefficients."""
    left_out = [SessionRow(k, arm.sessions[k], reason) for k, reason in arm.left_out]
    if left_out:
        yield LEFT_OUT.people(left_out, caption="Sessions that were not compared, and why")
    count = len(arm.sessions)
    rows = [SessionRow(k, arm.sessions[k], _part(arm, k)) for k in range(max(0, count - most), count)]
    cut = f"; the last {most} of {count}, all of them are in the file of sessions" if count > most else ""
    caption = f"Sessions, in the order of their {arm.ordered_by}s{cut}"
    yield SHOWN.people(rows, caption=caption, folded=count > ACROSS)
    for name, unit in drift_words.UNITS.items():
        for first in range(0, len(arm.joints), ACROSS):
            joints = arm.joints[first : first + ACROSS]
            which = f"of each session, {joints_label(one.joint for one in joints)}, with its 95 % interval [{unit}]"
            columns = (SESSION_NUMBER, *(coefficient_column(joint, name) for joint in joints))
            caption = f"{drift_words.NAMES[name].capitalize()} coefficient {which}{cut}"
            yield Record(columns).people(rows, caption=caption, folded=True)


def _part(arm: ArmDrift, k: int) -> str:
    return "reference" if k in arm.reference else "compared" if k in arm.compared else "left out"


def _failed_section(summary: BatchSummary) -> Iterator[html.Section]:
    if summary.failed:
        lead = html.Text(lines=("These files gave no session. They do not affect the others.",))
        table = FAILED.people(summary.failed, caption="Files that gave no session")
        yield html.Section(anchor="failed", title="Files that failed", parts=(lead, table))
