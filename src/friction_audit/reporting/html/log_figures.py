"""LogReport -> the figures of its page: which there are, what they show, and how they are made small and safe."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from friction_audit.reporting.drift_words import count_of
from friction_audit.reporting.figures.coefficients import draw_coefficients
from friction_audit.reporting.figures.diagnose_contacts import draw_verdicts
from friction_audit.reporting.figures.diagnose_evidence import draw_effects, draw_ladder
from friction_audit.reporting.figures.diagnose_look import verdict_words
from friction_audit.reporting.figures.diagnose_residual import draw_residual
from friction_audit.reporting.figures.diagnose_simulation import draw_simulation
from friction_audit.reporting.figures.energy import draw_energy
from friction_audit.reporting.figures.replay import draw_log_replay, draw_log_replay_velocity_torque
from friction_audit.reporting.figures.style import thin_extremes
from friction_audit.reporting.figures.velocity_torque import draw_velocity_torque
from friction_audit.reporting.html.log_part import part_of
from friction_audit.reporting.html.page import Figure
from friction_audit.reporting.html.svg import Picture, draw_inline
from friction_audit.reporting.log_report import JointReport, LogReport
from friction_audit.reporting.log_words import friction_words, removal_words
from friction_audit.reporting.terminal.estimate import joint_label
from friction_audit.reporting.units import label_in_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing
    from matplotlib.lines import Line2D

T = TypeVar("T")


class Draw(Protocol):
    """Draws a figure for a page."""

    def __call__(self, figure: "Drawing", *, prefix: str, description: str) -> Picture:
        """Return the figure.

        Args:
            figure: The figure.
            prefix: Unique among the figures of the page.
            description: What it shows, for those who do not see it.
        """


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
        tell: What it shows of a joint in words, for those who do not see it.
    """

    name: str
    section: str
    title: str
    caption: str
    draw: "Callable[[LogReport], Drawing]"
    has: Callable[[JointReport], bool]
    tell: Callable[[JointReport], str]


def _has_estimate(joint: JointReport) -> bool:
    return not joint.friction.reason


def _has_replay(joint: JointReport) -> bool:
    return joint.replay is not None and not joint.replay.reason


def _has_gap(joint: JointReport) -> bool:
    return joint.discrepancy is not None and joint.discrepancy.gap is not None


def _has_effects(joint: JointReport) -> bool:
    return joint.discrepancy is not None and bool(joint.discrepancy.effects)


def _tell_friction(joint: JointReport) -> str:
    return friction_words(joint.friction)


def _tell_energy(joint: JointReport) -> str:
    history = joint.friction.history
    taken = f", {history.dissipated_j.sum():.3g} J dissipated" if len(history.cycle) else ""
    return f"{count_of(joint.friction.cycles, 'cycle')}{taken}"


def _tell_replay(joint: JointReport) -> str:
    return "" if joint.replay is None else removal_words(joint.replay)


def _tell_verdict(joint: JointReport) -> str:
    found = joint.discrepancy
    if found is None or found.gap is None:
        return ""
    after = f" to {found.gap.after:.3g}" if found.effects else ""
    return f"{verdict_words(found)}, gap {found.gap.before:.3g}{after} N m rms, floor {found.gap.floor:.3g} N m"


LOG_FIGURES = (
    LogFigure(
        name="coefficients",
        section=FRICTION,
        title="Coefficients over time",
        caption="After each cycle the coefficients of the last cycles with their 95 % interval; dashed those of the "
        "whole log with theirs. Intervals that are far wider than the rest are cut at the edge.",
        draw=lambda report: draw_coefficients(report.estimate, None),
        has=_has_estimate,
        tell=_tell_friction,
    ),
    LogFigure(
        name="velocity-torque",
        section=FRICTION,
        title="Velocity-torque curves",
        caption="Interaction torque against velocity. Loops are inertia, which cancels between two moments of rest; "
        "the fitted line is the friction that is left.",
        draw=lambda report: draw_velocity_torque(report.estimate, None),
        has=_has_estimate,
        tell=_tell_friction,
    ),
    LogFigure(
        name="energy",
        section=FRICTION,
        title="Net energy and cycles",
        caption="Energy put into the joint. At zero velocity nothing is stored in the inertia, so that the rise from "
        "dot to dot is what friction took. Hatched cycles were left out.",
        draw=lambda report: draw_energy(report.estimate, None),
        has=_has_estimate,
        tell=_tell_energy,
    ),
    LogFigure(
        name="replay",
        section=COMPENSATOR,
        title="Torque, net energy and coefficients with the compensator",
        caption="Solid with the compensator, dashed without it; the coefficients are those that it would have applied. "
        "Flat energy means that friction costs the person nothing.",
        draw=lambda report: draw_log_replay(_given(report.replay), None),
        has=_has_replay,
        tell=_tell_replay,
    ),
    LogFigure(
        name="replay-velocity-torque",
        section=COMPENSATOR,
        title="Velocity-torque curves with the compensator",
        caption="Torque that the person has to give, without the compensator and with it from its first estimate on.",
        draw=lambda report: draw_log_replay_velocity_torque(_given(report.replay), None),
        has=_has_replay,
        tell=_tell_replay,
    ),
    LogFigure(
        name="verdicts",
        section=MISSING,
        title="Gap between model and measurement",
        caption="What the declared model leaves of the torque, what is left with the effects named, and the floor of "
        "the noise. The detection limit is the smallest effect that would have been seen.",
        draw=lambda report: draw_verdicts(_given(report.diagnosis), None),
        has=_has_gap,
        tell=_tell_verdict,
    ),
    LogFigure(
        name="ladder",
        section=MISSING,
        title="How the gap shrank",
        caption="From the declared model by each effect that was added down to the floor of the noise, on cycles that "
        "no choice was made on.",
        draw=lambda report: draw_ladder(_given(report.diagnosis), None),
        has=_has_gap,
        tell=_tell_verdict,
    ),
    LogFigure(
        name="residual",
        section=MISSING,
        title="Where model and measurement disagree",
        caption="Residual of the declared model, and with the effects named, against the quantity on which the "
        "strongest effect shows itself; dots are samples, markers means of bins with two standard errors.",
        draw=lambda report: draw_residual(_given(report.diagnosis), None),
        has=_has_gap,
        tell=_tell_verdict,
    ),
    LogFigure(
        name="effects",
        section=MISSING,
        title="The effects named",
        caption="Each effect as the log shows it, with its interval, and the fitted effect over it; what no one "
        "quantity shows is drawn over its own fitted torque, so that on the diagonal all that it says is in the log.",
        draw=lambda report: draw_effects(_given(report.diagnosis), None),
        has=_has_effects,
        tell=_tell_verdict,
    ),
    LogFigure(
        name="simulation",
        section=MISSING,
        title="Measured and simulated",
        caption="Torque and motion as measured, of the declared model and of the one grown by the effects named, on "
        "cycles that no choice was made on.",
        draw=lambda report: draw_simulation(_given(report.diagnosis), None),
        has=_has_gap,
        tell=_tell_verdict,
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


def draw_figures(report: LogReport, draw: Draw = draw_inline) -> Drawn:
    """Draw the figures sheet by sheet, all kinds of the first joints before those of the next, while there is room.

    Args:
        report: What the log says.
        draw: Draws a figure for the page.
    """
    drawn = Drawn(by_section={}, left_out={})
    left = MOST_BYTES
    for kind, part, title in _sheets(report):
        figure = _figure(kind, part, title, draw) if left > 0 else None
        left -= figure.picture.size if figure is not None else 0
        if figure is None or left < 0:
            drawn.left_out.setdefault(kind.section, []).append(title)
        else:
            drawn.by_section.setdefault(kind.section, []).append(figure)
    return drawn


def _sheets(report: LogReport) -> Iterator[tuple[LogFigure, LogReport, str]]:
    """Yield kind, joints and title of every figure."""
    every = [one.friction.joint for one in report.joints if any(kind.has(one) for kind in LOG_FIGURES)]
    for first in range(0, len(every), ON_A_SHEET):
        own = every[first : first + ON_A_SHEET]
        for kind in LOG_FIGURES:
            shown = [one.friction.joint for one in report.joints if one.friction.joint in own and kind.has(one)]
            which = "" if len(every) <= ON_A_SHEET else f", joints {own[0]} to {own[-1]}"
            if shown:
                yield kind, part_of(report, shown), f"{kind.title}{which}"


def _figure(kind: LogFigure, part: LogReport, title: str, draw: Draw) -> Figure:
    drawing = label_in_unit(kind.draw(part), part.estimate.log.source.torque_unit)
    _make_small(drawing)
    joints = part.joints
    words = [f"joint {joint_label(one.friction.joint, one.friction.name)}: {kind.tell(one)}" for one in joints]
    picture = draw(
        drawing, prefix=f"{kind.name}-{joints[0].friction.joint}", description=f"{title}. {'; '.join(words)}."
    )
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
