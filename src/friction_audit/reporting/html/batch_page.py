"""BatchSummary -> its figures and one HTML page: verdicts, figures, every session, every setting."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from friction_audit.drift.report import ArmDrift
from friction_audit.reporting import drift as tables, drift_words as phrases
from friction_audit.reporting.drift_sessions import LEFT_OUT, NUMBER, SESSION, SessionRow, coefficient_column
from friction_audit.reporting.figures import FigureKind, figures_of
from friction_audit.reporting.html import page as html
from friction_audit.reporting.notices import sentence_of, sentences, text_of
from friction_audit.reporting.table import Record, Table
from friction_audit.reporting.words import count_of, joint_label, joints_label

# Figures of one page together: a page of many arms shows those that drift, and names the others. [bytes]
MOST_BYTES = 1_600_000
ACROSS = 7  # joints side by side in a table of coefficients; more make another table
OF_A_TEST = ("changes", "control")  # figures that have nothing to show where too few sessions are compared
MOST_CELLS = 12_000  # coefficients that a page lists; all of them are in the file of sessions


def write_page(summary: tables.BatchSummary, drawn: Mapping[str, html.Figure]) -> str:
    """Return the page of a batch as HTML text, with figures by their anchors."""
    arms = summary.arms
    verdicts = tables.ARM.people(arms, caption="Drift of each arm")
    limits = [one[:1].upper() + one[1:] for one in phrases.limit_lines(summary.exceeded, summary.cannot_tell)]
    lead = html.Text(("These files gave no session. They do not affect the others.",))
    files = tables.FAILED.people(summary.failed, caption="Files that gave no session")
    failed = html.Section("failed", "Files that failed", (lead, files))
    noted = [*summary.warnings, *([sentences()["lines"]["drifts"]] if any(arm.drift for arm in arms) else [])]
    advice = html.Text(noted, listed=True, tone="unsure")
    exceeded = html.Text(limits, listed=True, tone="alert")
    pictures = _pictures(arms, drawn)
    most = max(1, MOST_CELLS // max(1, sum(len(phrases.UNITS) * max(len(arm.joints), 1) for arm in arms)))
    facts = {
        "Sessions": str(len(summary.sessions)), "Arms": str(len(arms)),
        "Recorded (UTC)": phrases.span_of(summary.sessions), "Files that failed": str(len(summary.failed)),
    }  # fmt: skip
    sections = (
        html.Section("verdicts", "Verdicts", (verdicts, advice, exceeded)),
        *(_arm_section(arm, f"arm-{k}", pictures.get(k, ()), most) for k, arm in enumerate(arms, start=1)),
        *([failed] if summary.failed else ()),
        *html.closing_sections(sentences()["batch_page"], summary.settings, summary.command),
    )
    return html.render_page(html.Page("Friction over sessions", phrases.batch_sentence(arms), facts, sections))


def _pictures(arms: tuple[ArmDrift, ...], drawn: Mapping[str, html.Figure]) -> dict[int, tuple[html.Figure, ...]]:
    """Return the figures of each arm, by its number, first of those that drift, of as many as there is room for."""
    found: dict[int, tuple[html.Figure, ...]] = {}
    left = MOST_BYTES
    for k in sorted(range(len(arms)), key=lambda k: not arms[k].drift):
        sheets = range(1, len(arms[k].joints) + 1, html.ON_A_SHEET)
        anchors = (f"arm-{k + 1}-{kind.name}-{first}" for kind in figures_of("drift") for first in sheets)
        figures = tuple(drawn[anchor] for anchor in anchors if anchor in drawn)
        left -= sum(len(figure.svg) for figure in figures)
        if left < 0 and found:
            break
        found[k + 1] = figures
    return found


def _arm_section(arm: ArmDrift, anchor: str, figures: tuple[html.Figure, ...], most: int) -> html.Section:
    no_room = f"This page has no room for more figures; those of {arm.robot} are in files next to it."
    no_test = f"There is no figure of changes and no control chart: {phrases.arm_sentence(arm)}."
    lacking = html.Text([no_room] * (not figures) + [no_test] * (not any(map(phrases.is_tested, arm.joints))))
    rows = tables.coefficient_rows(arm)
    steps = [row._replace(change=change) for row in rows for change in row.found.change_points]
    after = "the first session after each (with the range that holds it with 95 % confidence)"
    joints = (
        tables.COEFFICIENT.people(rows, caption="Change from the reference to the last sessions; intervals are 95 %"),
        tables.STEPS.people(steps, caption=f"Steps: {after}, and the levels"),
        tables.COEFFICIENT.people(rows, "n", caption="Levels, trends and control charts in numbers", folded=True),
    )
    within = tables.COEFFICIENT.people(rows, "w", caption=sentences()["lines"]["within"]).filled()
    sections = (
        html.Section(f"{anchor}-joints", "Joints", joints),
        html.Section(f"{anchor}-figures", "Figures", (*figures, lacking)),
        html.Section(f"{anchor}-within", "Within a session", (within,)),
        html.Section(f"{anchor}-diagnosis", "What the model misses", (_diagnosed(arm),)),
        html.Section(f"{anchor}-sessions", "Sessions", tuple(_session_tables(arm, most))),
    )
    noted = html.Text([*map(sentence_of, arm.warnings)], listed=True, tone="unsure")
    missing = [SessionRow(k, arm.sessions[k], text_of(reason)) for k, reason in arm.left_out]
    caption = "Sessions that were not compared, and why"
    left_out = LEFT_OUT.people(missing, caption=caption, folded=len(missing) > ACROSS)
    parts = (html.Text((f"{phrases.sessions_text(arm)}.",)), left_out, noted)
    return html.Section(anchor, arm.robot, parts, sections)


def _diagnosed(arm: ArmDrift) -> Table:
    """Return how often each effect was found on each joint that was diagnosed."""
    tested = [one for session in arm.sessions for one in session.joints if one.verdict]
    rows = []
    for joint in arm.joints:
        if own := [one for one in tested if one.joint == joint.joint]:
            verdicts = [one.verdict.replace("_", " ") for one in own if one.verdict]
            effects = [name for one in own for name in one.effects]
            counts = (Counter(found).most_common() for found in (verdicts, effects))
            rows.append((joint, *(", ".join(f"{name} {n}" for name, n in count) for count in counts)))
    return tables.DIAGNOSED.people(rows, caption="Verdicts and effects of the diagnosis, with the number of sessions")


def _session_tables(arm: ArmDrift, most: int) -> Iterator[Table]:
    """Yield the last ``most`` sessions, and their coefficients."""
    count = len(arm.sessions)
    part = dict.fromkeys(arm.compared, "compared") | dict.fromkeys(arm.reference, "reference")
    rows = [SessionRow(k, arm.sessions[k], part.get(k, "left out")) for k in range(max(0, count - most), count)]
    cut = f"; the last {most} of {count}, all of them are in the file of sessions" if count > most else ""
    caption = f"Sessions, in the order of their {arm.ordered_by}s{cut}"
    yield SESSION.people(rows, caption=caption, folded=count > ACROSS)
    for name, unit in phrases.UNITS.items():
        for first in range(0, len(arm.joints), ACROSS):
            joints = arm.joints[first : first + ACROSS]
            which = f"of each session, {joints_label(one.joint for one in joints)}, with its 95 % interval [{unit}]"
            columns = (NUMBER, *(coefficient_column(joint, name) for joint in joints))
            caption = f"{phrases.NAMES[name].capitalize()} coefficient {which}{cut}"
            yield Record(*columns).people(rows, caption=caption, folded=True)


class Drawing(NamedTuple):
    """A figure to be drawn; it can be given to another process."""

    kind: FigureKind
    arm: ArmDrift  # the arm, with the joints to be drawn, and no more of it than is drawn
    anchor: str = ""  # what its names in the page begin with; empty if it is for the files alone
    which: str = ""  # joints of a sheet of some, for its title on the page; empty for all
    name: str = ""  # of its files, without the suffix; empty if it is for the page alone
    formats: Sequence[str] = ()  # suffixes of its files


def drawings_of(arms: Sequence[ArmDrift], prefixes: Mapping[str, str], formats: Sequence[str]) -> Iterator[Drawing]:
    """Yield what is to be drawn of the arms; their files begin with the prefix of its name.

    More joints than fit on a sheet of paper make several on the page and one of all for the files.
    """
    for number, arm in enumerate(arms, start=1):
        tested = any(map(phrases.is_tested, arm.joints))
        for kind in (kind for kind in figures_of("drift") if tested or kind.name not in OF_A_TEST):
            sheets, name = list(html.sheets_of(arm.joints)), f"{prefixes.get(arm.robot, '')}{kind.name}"
            for k, (joints, which) in enumerate(sheets):
                part = as_drawn(replace(arm, joints=tuple(joints)))
                anchor = f"arm-{number}-{kind.name}-{html.ON_A_SHEET * k + 1}"
                sheet = Drawing(kind, part, anchor, which)
                yield sheet if sheets[1:] else sheet._replace(name=name, formats=formats)
            if sheets[1:]:
                yield Drawing(kind, as_drawn(arm), name=name, formats=formats)


def as_drawn(arm: ArmDrift) -> ArmDrift:
    """Return an arm with no more of its sessions than figures show: it goes to another process."""
    shown = {k for sessions in phrases.curve_sessions(arm) for k in sessions}
    for found in (found for one in arm.joints for found in one.coefficients if found.sessions):
        shown.update(set(range(len(arm.sessions))).difference(found.sessions))  # not compared: drawn as they are
    bare = (replace(one, joints=one.joints if k in shown else (), warnings=()) for k, one in enumerate(arm.sessions))
    return replace(arm, sessions=tuple(bare))


def draw(drawing: Drawing) -> tuple[dict[str, bytes], html.Figure | None]:
    """Draw a figure; return the content of its files by their names, and what stands on the page."""
    from friction_audit.reporting.figures.style import figure_bytes

    kind, arm = drawing.kind, drawing.arm
    figure = kind.draw(arm)
    files = {}
    for suffix in drawing.formats:
        files[f"{drawing.name}.{suffix}"] = figure_bytes(figure, suffix)
        figure.set_layout_engine("none")  # it has its place now; finding it takes half of the time
    if not drawing.anchor:
        return files, None
    joints = ((joint_label(one.joint, one.name), phrases.joint_sentence(arm, one)) for one in arm.joints)
    every = "; ".join(f"joint {label}: {sentence}" for label, sentence in joints)
    words = f"{kind.title}, {count_of(len(arm.sessions), 'session')} of arm {arm.robot}. {every}."
    title, caption = f"{kind.title}{drawing.which}", sentences()["captions"][kind.name]
    return files, html.draw_inline(figure, drawing.anchor, title=title, caption=caption, description=words)
