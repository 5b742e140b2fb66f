"""What figures show of a trial."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures.compare_sweeps import LOOKS, LOST, draw_sweeps
from friction_audit.reporting.figures.style import (
    COLUMN_IN,
    MUTED,
    add_legend,
    every_nth,
    figure_style,
    label_panel,
    new_figure,
    smooth,
    thin_extremes,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TrialCourse:
    """A method in one trial; n samples, up to where the loop was lost.

    Attributes:
        method: Name of the method.
        label: As in the legend.
        t: Time, shape (n,). [s]
        dq: Velocity of the joint shown, shape (n,). [rad/s]
        interaction_nm: Its interaction torque, shape (n,). [N m]
        energy_j: Net energy that the person has put into all joints, shape (n,). [J]
        from_s: End of the second cycle. [s]
        lost: Whether the loop was lost.
    """

    method: str
    label: str
    t: Float
    dq: Float
    interaction_nm: Float
    energy_j: Float
    from_s: float
    lost: bool


DRAWN = 2000


def draw_energies(courses: Sequence[TrialCourse]) -> "Figure":
    """Draw the net energies of all methods over time, in one panel as in the paper."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.9)
        axes = figure.subplots()
        axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
        handles: list[Artist] = []
        for course in courses:
            look, (t, energy) = LOOKS[course.method], thin_extremes(course.t, course.energy_j, DRAWN)
            handles += axes.plot(t, energy, color=look.colour, ls=look.dashes, lw=0.9, label=course.label)
            if course.lost:
                axes.plot(t[-1], energy[-1], "x", color=LOST, ms=5, mew=1.2, zorder=6)
        if any(course.lost for course in courses):
            handles += axes.plot([], [], "x", color=LOST, ms=5, mew=1.2, label="loop lost")
        handles.append(axes.axvline(courses[0].from_s, color=MUTED, lw=0.6, ls=":", label="end of 2nd cycle"))
        axes.margins(x=0.01)
        label_panel(axes, "")
        axes.set_xlabel("Time [s]")
        axes.set_ylabel("Net energy input [J]")
        add_legend(figure, handles)
        return figure


DRAWN_LOOPS = 3000
ACROSS = 3
LONGEST_TITLE = 16
"""Characters above a panel."""
GROUND = "#c8c8c8"
"""Colour of what every method is held against."""


def draw_loops(courses: Sequence[TrialCourse], joint: int) -> "Figure":
    """Draw a panel for every method, the first one's curve in the background of all others.

    Args:
        courses: The methods, after the second cycle; the first is no compensation.
        joint: Number of the joint.
    """
    rows = ceil(len(courses) / ACROSS)
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 0.3 + 1.3 * rows)
        panels = figure.subplots(rows, min(ACROSS, len(courses)), squeeze=False, sharex=True, sharey=True)
        for axes, course in zip(panels.flat, courses, strict=False):
            if course is not courses[0]:
                axes.plot(*_curve(courses[0]), color=GROUND, lw=0.5, zorder=1)
            axes.plot(*_curve(course), color=LOOKS[course.method].colour, lw=0.6, zorder=2)
            _finish(axes, course)
        for axes in panels.flat[len(courses) :]:
            axes.set_visible(False)
        for column in range(panels.shape[1]):
            panels.flat[max(n for n in range(len(courses)) if n % panels.shape[1] == column)].tick_params(
                labelbottom=True
            )
        figure.supxlabel(f"Velocity of joint {joint} [rad/s]", fontsize=7.5)
        figure.supylabel("Interaction torque [N m]", fontsize=7.5)
        return figure


def _finish(axes: "Axes", course: TrialCourse) -> None:
    axes.axhline(0.0, color=MUTED, lw=0.3, zorder=0)
    axes.axvline(0.0, color=MUTED, lw=0.3, zorder=0)
    label_panel(axes, fill(course.label, LONGEST_TITLE), across=3)
    if course.lost:
        axes.text(0.04, 0.96, "loop lost", transform=axes.transAxes, va="top", fontsize=6.5, color=LOST)


def _curve(course: TrialCourse) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and torque after the second cycle, filtered for the eye as in the paper."""
    part = course.t >= course.from_s
    if not part.any():
        return np.empty(0), np.empty(0)
    t = course.t[part]
    thin = every_nth(len(t), DRAWN_LOOPS)
    return smooth(t, course.dq[part])[thin], smooth(t, course.interaction_nm[part])[thin]


Row = Mapping[str, Any]

PANELS = (
    ("energy_slope_w", 1000.0, "(a) slope [mW]"),
    ("rms_torque_nm", 1.0, "(b) rms torque [N m]"),
)
LOST_AT = 0.97
"""Where a panel says how often a loop was lost, of its width."""

SHIFTS = {"paper": -0.14, "best": 0.14}
"""Where a role's marker stands, in rows."""


def draw_summary(rows: Iterable[Row]) -> "Figure":
    """Draw the paper's kind of tuning and the best one of every method, with 95 % intervals.

    Args:
        rows: Entries of ``methods`` in the document.
    """
    told = [row for row in rows if row["role"] in SHIFTS]
    labels = list(dict.fromkeys(row["label"] for row in told))
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 0.9 + 0.27 * len(labels))
        panels = figure.subplots(1, len(PANELS), sharey=True)
        for axes, (name, factor, title) in zip(panels, PANELS, strict=True):
            _draw_panel(axes, told, labels, name, factor)
            label_panel(axes, title, across=4)
            _tell_losses(axes, told, labels)
            axes.set_ylim(len(labels) - 0.5, -0.5)
            axes.set_yticks(range(len(labels)), labels)
            axes.tick_params(axis="y", length=0)
        shapes = (("o", "full", "the paper's kind of tuning"), ("D", "none", "best stable tuning"))
        handles = [
            panels[0].plot([], [], shape, color=MUTED, fillstyle=fill, ms=3.5, mew=0.8, label=label)[0]
            for shape, fill, label in shapes
        ]
        add_legend(figure, handles)
        return figure


def _tell_losses(axes: "Axes", rows: Sequence[Row], labels: Sequence[str]) -> None:
    """Write at the right how many loops were lost: those are not in the means."""
    for row in rows:
        if row["lost_s"]:
            axes.text(
                LOST_AT,
                labels.index(row["label"]) + SHIFTS[row["role"]],
                f"{1 - row['stable_share']:.0%} lost",
                transform=axes.get_yaxis_transform(),
                ha="right",
                va="center",
                fontsize=5.5,
                color=LOST,
            )


def _draw_panel(axes: "Axes", rows: Sequence[Row], labels: Sequence[str], name: str, factor: float) -> None:
    axes.axvline(0.0, color=MUTED, lw=0.4, zorder=1)
    alone = {row["label"] for row in rows if sum(other["label"] == row["label"] for other in rows) == 1}
    for row in rows:
        told, best = row[name], row["role"] == "best"
        place = labels.index(row["label"]) + (0.0 if row["label"] in alone else SHIFTS[row["role"]])
        value = factor * told["value"]
        low, high = (factor * bound for bound in told["ci95"])
        axes.errorbar(
            value,
            place,
            xerr=[[value - low], [high - value]],
            fmt="D" if best else "o",
            fillstyle="none" if best else "full",
            color=LOOKS[row["method"]].colour,
            ms=3.5,
            mew=0.8,
            elinewidth=0.8,
            capsize=1.5,
            zorder=3,
        )


__all__ = ["TrialCourse", "draw_energies", "draw_loops", "draw_summary", "draw_sweeps"]
