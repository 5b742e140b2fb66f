"""LogReport -> the figures of its page: which there are, what they show, and how they are made small and safe."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from friction_audit.errors import printable, shortened
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.reporting.diagnosis_words import verdict_words
from friction_audit.reporting.figures.coefficients import draw_coefficients
from friction_audit.reporting.figures.diagnose_contacts import draw_verdicts
from friction_audit.reporting.figures.diagnose_evidence import draw_effects, draw_ladder
from friction_audit.reporting.figures.diagnose_residual import draw_residual
from friction_audit.reporting.figures.diagnose_simulation import draw_simulation
from friction_audit.reporting.figures.energy import draw_energy
from friction_audit.reporting.figures.replay import draw_log_replay, draw_log_replay_velocity_torque
from friction_audit.reporting.figures.style import thin_extremes
from friction_audit.reporting.figures.velocity_torque import draw_velocity_torque
from friction_audit.reporting.html.page import Figure
from friction_audit.reporting.html.svg import draw_inline
from friction_audit.reporting.report import JointReport, LogReport, friction_words, removal_words
from friction_audit.reporting.units import label_in_unit
from friction_audit.reporting.words import SHORTEST_NAME, count_of, in_unit, joint_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing
    from matplotlib.lines import Line2D

T = TypeVar("T")


FRICTION, COMPENSATOR, MISSING = "friction", "compensator", "missing"
"""Sections that hold figures."""
MOST_BYTES = 2_500_000
"""Figures of one page together."""
ON_A_SHEET = 8
"""Joints of one figure."""
CLOUD = 300
"""Dots of one kind in a panel from which on they are an image: text would be larger than the rest of the page."""
COARSE = 0.5
"""Deviation of a drawn line that nobody sees. [pt]"""
MOST_POINTS = 1500
"""Points of a curve over time: more than a panel has dots of a screen, also enlarged."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LogFigure:
    """A kind of figure of the page of a log.

    Attributes:
        name: Unique name.
        section: Where it stands.
        title: What it shows, in a line.
        caption: How to read it.
        draw: Draws all joints of a report on a sheet.
        has: Whether it has something to show of a joint.
        describe: What it shows of a joint in words, for those who do not see it.
    """

    name: str
    section: str
    title: str
    caption: str
    draw: "Callable[[LogReport], Drawing]"
    has: Callable[[JointReport], bool]
    describe: Callable[[JointReport], str]


def _has_estimate(joint: JointReport) -> bool:
    return not joint.friction.reason


def _has_replay(joint: JointReport) -> bool:
    return joint.replay is not None and not joint.replay.reason


def _has_gap(joint: JointReport) -> bool:
    return joint.discrepancy is not None and joint.discrepancy.gap is not None


def _has_effects(joint: JointReport) -> bool:
    return joint.discrepancy is not None and bool(joint.discrepancy.effects)


def _describe_friction(joint: JointReport) -> str:
    return friction_words(joint.friction)


def _describe_energy(joint: JointReport) -> str:
    history = joint.friction.history
    taken = f", {history.dissipated_j.sum():.3g} J dissipated" if len(history.cycle) else ""
    return f"{count_of(joint.friction.cycles, 'cycle')}{taken}"


def _describe_replay(joint: JointReport) -> str:
    return "" if joint.replay is None else removal_words(joint.replay)


def _describe_verdict(joint: JointReport) -> str:
    found = joint.discrepancy
    if found is None or found.gap is None:
        return ""
    after = f" to {found.gap.after:.3g}" if found.effects else ""
    return (
        f"{verdict_words(found)}, residual RMS {found.gap.before:.3g}{after} N m, noise floor {found.gap.floor:.3g} N m"
    )


LOG_FIGURES = (
    LogFigure(
        name="coefficients",
        section=FRICTION,
        title="Coefficients over time",
        caption="After each cycle the coefficients of the last cycles with their 95 % interval; dashed those of the "
        "whole log with theirs. Intervals that are far wider than the rest are cut at the edge.",
        draw=lambda report: draw_coefficients(report.estimate, None),
        has=_has_estimate,
        describe=_describe_friction,
    ),
    LogFigure(
        name="velocity-torque",
        section=FRICTION,
        title="Velocity-torque curves",
        caption="Interaction torque against velocity. Loops are inertia, which cancels between two moments of rest; "
        "the fitted line is the friction that is left.",
        draw=lambda report: draw_velocity_torque(report.estimate, None),
        has=_has_estimate,
        describe=_describe_friction,
    ),
    LogFigure(
        name="energy",
        section=FRICTION,
        title="Net energy and cycles",
        caption="Energy put into the joint. At zero velocity nothing is stored in the inertia, so that the rise from "
        "dot to dot is what friction took. Hatched cycles were rejected.",
        draw=lambda report: draw_energy(report.estimate, None),
        has=_has_estimate,
        describe=_describe_energy,
    ),
    LogFigure(
        name="replay",
        section=COMPENSATOR,
        title="Torque, net energy and coefficients with the compensator",
        caption="Solid with the compensator, dashed without it; the coefficients are those that it would have applied. "
        "Flat energy means that friction costs the person nothing.",
        draw=lambda report: draw_log_replay(_given(report.replay), None),
        has=_has_replay,
        describe=_describe_replay,
    ),
    LogFigure(
        name="replay-velocity-torque",
        section=COMPENSATOR,
        title="Velocity-torque curves with the compensator",
        caption="Torque that the person has to give, without the compensator and with it from its first estimate on.",
        draw=lambda report: draw_log_replay_velocity_torque(_given(report.replay), None),
        has=_has_replay,
        describe=_describe_replay,
    ),
    LogFigure(
        name="verdicts",
        section=MISSING,
        title="Residual of the model",
        caption="Residual RMS of the nominal model, of the model augmented by the effects named, and of the noise. The "
        "detection limit is the smallest effect that is detected with 90 % power.",
        draw=lambda report: draw_verdicts(_given(report.diagnosis), None),
        has=_has_gap,
        describe=_describe_verdict,
    ),
    LogFigure(
        name="ladder",
        section=MISSING,
        title="Residual after each effect",
        caption="Residual RMS from the nominal model by each effect that was added down to the noise floor, on "
        "held-out cycles.",
        draw=lambda report: draw_ladder(_given(report.diagnosis), None),
        has=_has_gap,
        describe=_describe_verdict,
    ),
    LogFigure(
        name="residual",
        section=MISSING,
        title="Where model and measurement disagree",
        caption="Residual of the nominal model, and with the effects named, against the quantity on which the "
        "strongest effect shows itself; dots are samples, markers means of bins with two standard errors.",
        draw=lambda report: draw_residual(_given(report.diagnosis), None),
        has=_has_gap,
        describe=_describe_verdict,
    ),
    LogFigure(
        name="effects",
        section=MISSING,
        title="The effects named",
        caption="Each effect as the log shows it, with its interval, and the fitted effect over it; an effect that "
        "no single quantity shows is drawn over its own fitted torque: dots on the diagonal confirm it.",
        draw=lambda report: draw_effects(_given(report.diagnosis), None),
        has=_has_effects,
        describe=_describe_verdict,
    ),
    LogFigure(
        name="simulation",
        section=MISSING,
        title="Measured and simulated",
        caption="Torque and motion as measured, of the nominal model and of the model augmented by the effects named, "
        "on held-out cycles.",
        draw=lambda report: draw_simulation(_given(report.diagnosis), None),
        has=_has_gap,
        describe=_describe_verdict,
    ),
)
"""In the order in which they are read."""


def _given(part: T | None) -> T:
    assert part is not None
    return part


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
        if figure is None or left < 0:
            drawn.left_out.setdefault(kind.section, []).append(title)
        else:
            drawn.by_section.setdefault(kind.section, []).append(figure)
    return drawn


def _sheets(report: LogReport) -> Iterator[tuple[LogFigure, LogReport, str]]:
    """Yield kind, joints and title of every figure."""
    every = [one.joint for one in report.joints if any(kind.has(one) for kind in LOG_FIGURES)]
    for first in range(0, len(every), ON_A_SHEET):
        own = every[first : first + ON_A_SHEET]
        for kind in LOG_FIGURES:
            shown = [one.joint for one in report.joints if one.joint in own and kind.has(one)]
            which = "" if len(every) <= ON_A_SHEET else f", joints {own[0]} to {own[-1]}"
            if shown:
                yield kind, part_of(report, shown), f"{kind.title}{which}"


def _figure(kind: LogFigure, part: LogReport, title: str) -> Figure:
    drawing = label_in_unit(kind.draw(part), part.unit)
    _make_small(drawing)
    joints = part.joints
    words = [f"joint {joint_label(one.joint, one.name)}: {kind.describe(one)}" for one in joints]
    description = in_unit(f"{title}. {'; '.join(words)}.", part.unit)
    picture = draw_inline(drawing, prefix=f"{kind.name}-{joints[0].joint}", description=description)
    return Figure(picture=picture, title=title, caption=kind.caption)


def _make_small(drawing: "Drawing") -> None:
    """Let clouds of dots be images and all else lines in the page's colours."""
    from matplotlib.lines import Line2D

    for line in drawing.findobj(Line2D):
        cloud = line.get_linestyle() == "None" and len(np.atleast_1d(line.get_xdata())) > CLOUD
        line.set_rasterized(cloud)
        _thin(line)


def _thin(line: "Line2D") -> None:
    """Leave of a curve over time the smallest and largest of every stretch, of others what differs visibly."""
    x, y = np.asarray(line.get_xdata(), dtype=np.float64), np.asarray(line.get_ydata(), dtype=np.float64)
    rising = len(x) > MOST_POINTS and line.get_linestyle() != "None" and bool((np.diff(x) > 0.0).all())
    if rising and line.get_drawstyle() == "default" and bool(np.isfinite(y).all()):
        line.set_data(*thin_extremes(x, y, MOST_POINTS))
    line.get_path().simplify_threshold = COARSE


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
