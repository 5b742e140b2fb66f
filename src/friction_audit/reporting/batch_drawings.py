"""Figures of a batch: what is drawn of an arm, what each shows in words, its files and its place on the page."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.reporting.drift_words import NAMES, change_text, drift_verdict, joint_verdict, total_text
from friction_audit.reporting.figures.drift import curve_sessions
from friction_audit.reporting.figures.registry import Figure, figure_names, figures_of
from friction_audit.reporting.words import count_of, joint_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure

    from friction_audit.reporting.html.page import Figure as PageFigure


LEADS = {
    "changes": "Change of the coefficients of each joint",
    "drift": "Friction coefficients of each joint over the sessions",
    "control": "Deviation of each session from the reference, joint by joint",
    "curves": "Torque against velocity of each joint in the first session, the reference and the last session",
}


def describe(arm: ArmDrift, figure: str) -> str:
    """Return what a figure shows in words: of how many sessions, and what became of each joint."""
    said = "; ".join(_joint(arm, joint, figure) for joint in arm.joints)
    return f"{LEADS[figure]}, {count_of(len(arm.sessions), 'session')} of arm {arm.robot}. {said}."


def _joint(arm: ArmDrift, joint: JointDrift, figure: str) -> str:
    name = f"joint {joint_label(joint.joint, joint.name)}"
    if figure == "curves":
        return f"{name}: {joint_verdict(joint)}"
    if figure == "control":
        outside = sum(point.outside for found in joint.coefficients for point in found.control)
        return f"{name}: {count_of(outside, 'point')} outside the limits"
    return f"{name}: {', '.join(_coefficients(arm, joint))}"


def _coefficients(arm: ArmDrift, joint: JointDrift) -> list[str]:
    """Return what became of each coefficient, with its change and steps."""
    words = []
    for found in joint.coefficients:
        steps = "".join(f", step at {change_text(arm, change)}" for change in found.change_points)
        words.append(f"{NAMES[found.coefficient]} {drift_verdict(found)}, {total_text(found)}{steps}")
    return words


ON_A_SHEET = 8
"""Joints of one figure of the page."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Drawing:
    """A figure to be drawn; it can be given to another process.

    Attributes:
        name: Of its files, without the suffix; empty if it is for the page alone.
        kind: Name of the kind of figure.
        arm: The arm, with the joints to be drawn, and no more of it than is drawn.
        joint: Number of the one joint to be drawn at column width, or None for a sheet.
        formats: Suffixes of its files.
        anchor: What its names in the page begin with; empty if it is for the files alone.
        which: Joints of a sheet of some, for its title on the page; empty for all.
    """

    name: str
    kind: str
    arm: ArmDrift
    joint: int | None = None
    formats: tuple[str, ...] = ()
    anchor: str = ""
    which: str = ""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Drawn:
    """What came of a drawing.

    Attributes:
        files: Content of its files by their names.
        figure: What stands on the page, or None.
    """

    files: Mapping[str, bytes]
    figure: "PageFigure | None"


def drawings_of(arms: Sequence[ArmDrift], prefixes: Mapping[str, str], formats: Sequence[str]) -> Iterator[Drawing]:
    """Yield what is to be drawn of the arms that have joints.

    Args:
        arms: All arms of a batch.
        prefixes: What the names of each arm's files begin with, by the arm's name.
        formats: Suffixes of the files.
    """
    for number, arm in enumerate(arms, start=1):
        for kind in figure_names("drift") if arm.joints else ():
            sheets = list(page_drawings(arm, f"arm-{number}", kind))
            name, suffixes = f"{prefixes[arm.robot]}{kind}", tuple(formats)
            if len(sheets) == 1 and len(arm.joints) > 1:
                yield replace(sheets[0], name=name, formats=suffixes)
                continue
            yield from sheets
            # A sheet of one joint is that joint's figure.
            joint = arm.joints[0].joint if len(arm.joints) == 1 else None
            yield Drawing(name=name, kind=kind, arm=as_drawn(arm, kind), joint=joint, formats=suffixes)


def page_drawings(arm: ArmDrift, anchor: str, kind: str) -> Iterator[Drawing]:
    """Yield the figures of a kind on the page; more joints than fit on a sheet of paper make several."""
    for first in range(0, len(arm.joints), ON_A_SHEET):
        part = as_drawn(replace(arm, joints=arm.joints[first : first + ON_A_SHEET]), kind)
        some = f", joints {part.joints[0].joint} to {part.joints[-1].joint}"
        yield Drawing(
            name="",
            kind=kind,
            arm=part,
            anchor=f"{anchor}-{kind}-{first + 1}",
            which="" if len(part.joints) == len(arm.joints) else some,
        )


def draw(drawing: Drawing) -> Drawn:
    """Draw a figure, and save it in all its forms."""
    from friction_audit.reporting.figures.style import figure_bytes

    figure = _kind(drawing).draw(drawing.arm, drawing.joint)
    files = {}
    for suffix in drawing.formats:
        files[f"{drawing.name}.{suffix}"] = figure_bytes(figure, suffix)
        figure.set_layout_engine("none")  # it has its place now; finding it takes half of the time
    return Drawn(files=files, figure=_on_page(figure, drawing) if drawing.anchor else None)


def _on_page(figure: "MatplotlibFigure", drawing: Drawing) -> "PageFigure":
    from friction_audit.reporting.html.page import Figure as PageFigure
    from friction_audit.reporting.html.page import draw_inline

    picture = draw_inline(figure, prefix=drawing.anchor, description=describe(drawing.arm, drawing.kind))
    kind = _kind(drawing)
    return PageFigure(picture=picture, title=f"{kind.title}{drawing.which}", caption=kind.caption)


def _kind(drawing: Drawing) -> Figure:
    return next(kind for kind in figures_of("drift") if kind.name == drawing.kind)


Kept = Mapping[int, Collection[int]]
"""Sessions whose summary of a joint a figure shows, by the joint."""


def as_drawn(arm: ArmDrift, kind: str) -> ArmDrift:
    """Return an arm without what a kind of figure does not show.

    Of every joint the first estimate and the first curve stay: they tell that there is something to draw.

    Args:
        arm: The arm, with the joints to be drawn.
        kind: Name of the kind of figure.
    """
    kept = {joint.joint: _first_curve(arm, joint.joint) | _shown(arm, joint, kind) for joint in arm.joints}
    return replace(
        arm,
        sessions=tuple(_bare(session, index, kept) for index, session in enumerate(arm.sessions)),
        joints=tuple(
            replace(joint, coefficients=tuple(_shortened(found, kind) for found in joint.coefficients))
            for joint in arm.joints
        ),
    )


def _shown(arm: ArmDrift, joint: JointDrift, kind: str) -> set[int]:
    """Return the sessions whose own summary of a joint is drawn."""
    if kind == "curves":
        drawn = curve_sessions(arm)
        return set() if drawn is None else {drawn[0], *drawn[1], drawn[2]}
    if kind == "drift":  # those that were not compared are drawn as they are
        return {k for found in joint.coefficients for k in set(range(len(arm.sessions))).difference(found.sessions)}
    return set()


def _first_curve(arm: ArmDrift, joint: int) -> set[int]:
    moved = (
        index
        for index, session in enumerate(arm.sessions)
        for one in session.joints
        if one.joint == joint and one.curve.speed_rad_s
    )
    return {index for index in (next(moved, None),) if index is not None}


def _bare(session: Session, index: int, kept: Kept) -> Session:
    joints = tuple(joint for joint in session.joints if index in kept.get(joint.joint, ()))
    return replace(session, joints=joints, warnings=())


def _shortened(found: CoefficientDrift, kind: str) -> CoefficientDrift:
    """Return what became of a coefficient without the series that are not drawn."""
    control = found.control if kind == "control" else ()
    if kind == "drift":
        return replace(found, control=control)
    first = next((k for k, value in enumerate(found.values) if math.isfinite(value.value)), 0)
    part = slice(first, first + 1)
    return replace(found, values=found.values[part], control=control)
