"""Figures of a batch: what is drawn of an arm, what each shows in words, its files and its place on the page."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from friction_audit.drift.report import ArmDrift, JointDrift
from friction_audit.reporting.drift_words import NAMES, change_text, drift_verdict, joint_verdict, total_text
from friction_audit.reporting.figures.curves import curve_sessions
from friction_audit.reporting.figures.registry import Figure, figures_of
from friction_audit.reporting.words import count_of, joint_label

if TYPE_CHECKING:
    from friction_audit.reporting.html.page import Figure as PageFigure


def describe(arm: ArmDrift, kind: Figure) -> str:
    """Return what a figure shows in words: of how many sessions, and what became of each joint."""
    said = "; ".join(f"joint {joint_label(one.joint, one.name)}: {_said(arm, one, kind.name)}" for one in arm.joints)
    return f"{kind.title}, {count_of(len(arm.sessions), 'session')} of arm {arm.robot}. {said}."


def _said(arm: ArmDrift, joint: JointDrift, figure: str) -> str:
    if figure == "curves":
        return joint_verdict(joint)
    if figure == "control":
        outside = sum(point.outside for found in joint.coefficients for point in found.control)
        return f"{count_of(outside, 'point')} outside the limits"
    words = []
    for found in joint.coefficients:
        steps = "".join(f", step at {change_text(arm, change)}" for change in found.change_points)
        words.append(f"{NAMES[found.coefficient]} {drift_verdict(found)}, {total_text(found)}{steps}")
    return ", ".join(words)


ON_A_SHEET = 8
"""Joints of one figure of the page."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Drawing:
    """A figure to be drawn; it can be given to another process."""

    kind: Figure
    arm: ArmDrift  # the arm, with the joints to be drawn, and no more of it than is drawn
    anchor: str = ""  # what its names in the page begin with; empty if it is for the files alone
    which: str = ""  # joints of a sheet of some, for its title on the page; empty for all
    name: str = ""  # of its files, without the suffix; empty if it is for the page alone
    formats: Sequence[str] = ()  # suffixes of its files


class Drawn(NamedTuple):
    """Content of the files by their names, and what stands on the page, or None."""

    files: Mapping[str, bytes]
    figure: "PageFigure | None"


def drawings_of(arms: Sequence[ArmDrift], prefixes: Mapping[str, str], formats: Sequence[str]) -> Iterator[Drawing]:
    """Yield what is to be drawn of the arms that have joints; their files begin with the prefix of its name."""
    for number, arm in enumerate(arms, start=1):
        for kind in figures_of("drift"):
            name = f"{prefixes.get(arm.robot, '')}{kind.name}"
            match list(page_drawings(arm, f"arm-{number}", kind)):
                case [alone]:
                    yield replace(alone, name=name, formats=formats)
                case [*sheets] if sheets:
                    yield from sheets
                    yield Drawing(kind=kind, arm=as_drawn(arm, kind), name=name, formats=formats)


def page_drawings(arm: ArmDrift, anchor: str, kind: Figure) -> Iterator[Drawing]:
    """Yield the figures of a kind on the page; more joints than fit on a sheet of paper make several."""
    for first in range(0, len(arm.joints), ON_A_SHEET):
        part = as_drawn(replace(arm, joints=arm.joints[first : first + ON_A_SHEET]), kind)
        whole = len(part.joints) == len(arm.joints)
        which = "" if whole else f", joints {part.joints[0].joint} to {part.joints[-1].joint}"
        yield Drawing(kind=kind, arm=part, anchor=f"{anchor}-{kind.name}-{first + 1}", which=which)


def as_drawn(arm: ArmDrift, kind: Figure) -> ArmDrift:
    """Return an arm with no more of its sessions than a figure shows: it goes to another process."""
    shown: set[int] = set()
    if kind.name == "curves":
        first, reference, last = curve_sessions(arm)
        shown = {first, *reference, last}
    elif kind.name == "drift":  # sessions that were not compared are drawn as they are
        compared = [found.sessions for one in arm.joints for found in one.coefficients if found.sessions]
        shown = {k for sessions in compared for k in set(range(len(arm.sessions))).difference(sessions)}
    bare = (replace(one, joints=one.joints if k in shown else (), warnings=()) for k, one in enumerate(arm.sessions))
    return replace(arm, sessions=tuple(bare))


def draw(drawing: Drawing) -> Drawn:
    """Draw a figure, and save it in all its forms."""
    from friction_audit.reporting.figures.style import figure_bytes
    from friction_audit.reporting.html.page import draw_inline

    kind, arm = drawing.kind, drawing.arm
    figure = kind.draw(arm)
    files = {}
    for suffix in drawing.formats:
        files[f"{drawing.name}.{suffix}"] = figure_bytes(figure, suffix)
        figure.set_layout_engine("none")  # it has its place now; finding it takes half of the time
    if not drawing.anchor:
        return Drawn(files, None)
    title, words = f"{kind.title}{drawing.which}", describe(arm, kind)
    return Drawn(files, draw_inline(figure, drawing.anchor, title=title, caption=kind.caption, description=words))
