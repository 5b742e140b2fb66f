"""LogReport -> the figures of its page: which there are, what they show, and how they are made small."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.errors import printable, shortened
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.reporting.diagnosis_words import verdict_words
from friction_audit.reporting.figures.panels import label_in_unit, thin_extremes
from friction_audit.reporting.figures.registry import Figure as FigureKind
from friction_audit.reporting.figures.registry import figures_of
from friction_audit.reporting.html.page import Figure
from friction_audit.reporting.html.svg import draw_inline
from friction_audit.reporting.report import JointReport, LogReport, friction_words, removal_words
from friction_audit.reporting.words import SHORTEST_NAME, count_of, in_unit, joint_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

FRICTION, COMPENSATOR, MISSING = "friction", "compensator", "missing"  # sections that hold figures
SECTIONS = {"estimate": FRICTION, "replay": COMPENSATOR, "diagnosis": MISSING}  # by the result that a figure draws
LOG_FIGURES = tuple(kind for kind in figures_of(*SECTIONS) if kind.caption)
MOST_BYTES = 2_500_000  # figures of one page together
ON_A_SHEET = 8  # joints of one figure
CLOUD = 300  # dots in a panel from which on they are an image: text would be larger than the rest of the page
COARSE_PT = 0.5  # invisible deviation of a drawn line
MOST_POINTS = 1500  # points of a curve over time: more than a panel has dots of a screen, also enlarged


@dataclass(frozen=True, kw_only=True, slots=True)
class Drawn:
    """The figures of a page by section, and what there was no room for.

    Attributes:
        by_section: Figures, in order.
        left_out: Titles of figures that found no room, by section.
    """

    by_section: dict[str, list[Figure]]
    left_out: dict[str, list[str]]


def draw_figures(report: LogReport) -> Drawn:
    """Draw the figures sheet by sheet, all kinds of the first joints before those of the next, while there is room."""
    drawn = Drawn(by_section={}, left_out={})
    left = MOST_BYTES
    for kind, part, title in _sheets(report):
        figure = _figure(kind, part, title) if left > 0 else None
        left -= len(figure.picture.svg) if figure is not None else 0
        section = SECTIONS[kind.result]
        if figure is None or left < 0:
            drawn.left_out.setdefault(section, []).append(title)
        else:
            drawn.by_section.setdefault(section, []).append(figure)
    return drawn


def _has(kind: FigureKind, joint: JointReport) -> bool:
    """Return whether a figure has something to show of a joint."""
    if kind.result == "estimate":
        return not joint.friction.reason
    if kind.result == "replay":
        return joint.replay is not None and not joint.replay.reason
    found = joint.discrepancy
    return found is not None and bool(found.effects if kind.name == "effects" else found.gap)


def _describe(kind: FigureKind, joint: JointReport) -> str:
    """Return what a figure shows of a joint in words, for those who do not see it."""
    if kind.name == "energy":
        history = joint.friction.history
        taken = f", {history.dissipated_j.sum():.3g} J dissipated" if len(history.cycle) else ""
        return f"{count_of(joint.friction.cycles, 'cycle')}{taken}"
    if kind.result == "estimate":
        return friction_words(joint.friction)
    if kind.result == "replay":
        return "" if joint.replay is None else removal_words(joint.replay)
    found = joint.discrepancy
    if found is None or found.gap is None:
        return ""
    after = f" to {found.gap.after:.3g}" if found.effects else ""
    residual = f"residual RMS {found.gap.before:.3g}{after} N m, noise floor {found.gap.floor:.3g} N m"
    return f"{verdict_words(found)}, {residual}"


def _sheets(report: LogReport) -> Iterator[tuple[FigureKind, LogReport, str]]:
    """Yield kind, joints and title of every figure."""
    every = [one.joint for one in report.joints if any(_has(kind, one) for kind in LOG_FIGURES)]
    for first in range(0, len(every), ON_A_SHEET):
        own = every[first : first + ON_A_SHEET]
        for kind in LOG_FIGURES:
            shown = [one.joint for one in report.joints if one.joint in own and _has(kind, one)]
            which = "" if len(every) <= ON_A_SHEET else f", joints {own[0]} to {own[-1]}"
            if shown:
                yield kind, part_of(report, shown), f"{kind.title}{which}"


def _figure(kind: FigureKind, part: LogReport, title: str) -> Figure:
    drawing = label_in_unit(kind.draw(getattr(part, kind.result)), part.unit)
    _make_small(drawing)
    joints = part.joints
    words = [f"joint {joint_label(one.joint, one.name)}: {_describe(kind, one)}" for one in joints]
    description = in_unit(f"{title}. {'; '.join(words)}.", part.unit)
    picture = draw_inline(drawing, prefix=f"{kind.name}-{joints[0].joint}", description=description)
    return Figure(picture=picture, title=title, caption=kind.caption)


def _make_small(drawing: "Drawing") -> None:
    """Let clouds of dots be images, and leave of curves what is visible."""
    from matplotlib.lines import Line2D

    for line in drawing.findobj(Line2D):
        assert isinstance(line, Line2D)
        x, y = (np.asarray(data, dtype=np.float64) for data in line.get_data())
        dots = line.get_linestyle() == "None"
        line.set_rasterized(dots and len(x) > CLOUD)
        long = len(x) > MOST_POINTS and not dots and line.get_drawstyle() == "default"
        if long and bool((np.diff(x) > 0.0).all() and np.isfinite(y).all()):
            line.set_data(*thin_extremes(x, y, MOST_POINTS))
        line.get_path().simplify_threshold = COARSE_PT


# Fields of EnergyCycles with one entry per joint.
PER_JOINT = ("initiation", "termination", "fastest", "standstill_rad_s", "moving_s")
# Letters of a name that fit along the left edge of a panel.
ALONG = 9


def part_of(report: LogReport, numbers: Collection[int]) -> LogReport:
    """Return the report of some joints, given by their numbers for people; its estimate is for drawing only."""
    diagnosis, replayed = report.diagnosis, report.replay
    if diagnosis is not None:
        joints = tuple(
            replace(one, name=_fitting(one.joint, one.name))
            for one in diagnosis.discrepancy.joints
            if one.joint in numbers
        )
        diagnosis = replace(diagnosis, discrepancy=replace(diagnosis.discrepancy, joints=joints))
    if replayed is not None:
        own = tuple(
            replace(one, name=_fitting(one.joint, one.name, ALONG))
            for one in replayed.replay.joints
            if one.joint in numbers
        )
        replayed = replace(replayed, replay=replace(replayed.replay, joints=own))
    return replace(report, estimate=_estimate(report.estimate, numbers), diagnosis=diagnosis, replay=replayed)


def _fitting(joint: int, name: str, most: int = SHORTEST_NAME) -> str:
    """Return a name in so many letters, by default what fits above a panel; none where it says only the number."""
    return "" if joint_label(joint, name) == str(joint) else shortened(printable(name), most)


def _estimate(estimate: Estimate, numbers: Collection[int]) -> Estimate:
    columns = [k for k, number in enumerate(estimate.interaction.joint_numbers) if number in numbers]
    joints = tuple(
        replace(one, name=_fitting(one.joint, one.name)) for one in estimate.friction.joints if one.joint in numbers
    )
    return replace(
        estimate,
        interaction=_interaction(estimate.interaction, columns),
        cycles=_cycles(estimate.cycles, columns),
        friction=replace(estimate.friction, joints=joints),
    )


def _interaction(whole: Interaction, columns: list[int]) -> Interaction:
    compensation, gravity = whole.compensation, whole.gravity_direction
    return replace(
        whole,
        q=whole.q[:, columns],
        dq=whole.dq[:, columns],
        torque=whole.torque[:, columns],
        compensation=None if compensation is None else compensation[:, columns],
        gravity_direction=None if gravity is None else gravity[:, columns],
        joint_numbers=tuple(whole.joint_numbers[k] for k in columns),
        joint_names=tuple(_fitting(whole.joint_numbers[k], whole.joint_names[k]) for k in columns),
    )


def _cycles(cycles: EnergyCycles, columns: list[int]) -> EnergyCycles:
    """Return the cycles of some columns, counted anew."""
    kept = cycles.rows(np.isin(cycles.joint, columns))
    own = {name: getattr(kept, name)[columns] for name in PER_JOINT}
    return replace(kept, joint=np.searchsorted(columns, kept.joint), **own)
