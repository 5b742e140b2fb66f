"""Figures of a batch: what is drawn of an arm, what it shows in words, its files and its place on the page."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from friction_audit.drift.report import ArmDrift, JointDrift
from friction_audit.reporting.drift_words import NAMES, change_text, curve_sessions, drift_verdict, total_text
from friction_audit.reporting.figures.registry import Figure, figures_of
from friction_audit.reporting.words import count_of, joint_label

if TYPE_CHECKING:
    from friction_audit.reporting.html.page import Figure as PageFigure

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
                    yield Drawing(kind=kind, arm=as_drawn(arm), name=name, formats=formats)


def page_drawings(arm: ArmDrift, anchor: str, kind: Figure) -> Iterator[Drawing]:
    """Yield the figures of a kind on the page; more joints than fit on a sheet of paper make several."""
    for first in range(0, len(arm.joints), ON_A_SHEET):
        joints = arm.joints[first : first + ON_A_SHEET]
        which = "" if len(joints) == len(arm.joints) else f", joints {joints[0].joint} to {joints[-1].joint}"
        part = as_drawn(replace(arm, joints=joints))
        yield Drawing(kind=kind, arm=part, anchor=f"{anchor}-{kind.name}-{first + 1}", which=which)


def as_drawn(arm: ArmDrift) -> ArmDrift:
    """Return an arm with no more of its sessions than figures show: it goes to another process."""
    first, reference, last = curve_sessions(arm)
    shown = {first, *reference, last}
    for found in (found for one in arm.joints for found in one.coefficients if found.sessions):
        shown.update(set(range(len(arm.sessions))).difference(found.sessions))  # not compared: drawn as they are
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
    every = "; ".join(f"joint {joint_label(one.joint, one.name)}: {_describe(arm, one)}" for one in arm.joints)
    words = f"{kind.title}, {count_of(len(arm.sessions), 'session')} of arm {arm.robot}. {every}."
    title = f"{kind.title}{drawing.which}"
    return Drawn(files, draw_inline(figure, drawing.anchor, title=title, caption=kind.caption, description=words))


def _describe(arm: ArmDrift, joint: JointDrift) -> str:
    """Return what became of a joint, for those who do not see the figure."""
    words = []
    for found in joint.coefficients:
        steps = "".join(f", step at {change_text(arm, change)}" for change in found.change_points)
        words.append(f"{NAMES[found.coefficient]} {drift_verdict(found)}, {total_text(found)}{steps}")
    return ", ".join(words)
