"""The residual against the quantity on which an effect shows itself, before and after it was added."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.diagnosis.result import JointDiscrepancy, Profile
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.figures.diagnose_look import (
    BACKWARDS,
    FORWARDS,
    HEAD_IN,
    MOST_DOTS,
    STANDARD_ERRORS,
    OwnAxis,
    added,
    chosen_joints,
    declared_name,
    grown_name,
    joint_name,
    once,
    own_axis,
    own_profile,
    profile_along,
    say_why,
)
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    MUTED,
    SHEET_IN,
    add_legend,
    every_nth,
    figure_style,
    is_narrow,
    label_panel,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHEET_ROW_IN, PANEL_IN = 1.4, 1.55
NARROW, WIDE = 52, 52
"""Characters of a line of a title, at column width and on a sheet."""
OUTSIDE = 0.005
"""Share of the rows that may lie above a panel, and below;"""
NEAR = 1.5
"""more where they reach farther beyond the means than so many times their range, which would then be hard to see."""
MARGIN = 0.04
STRETCHED, WIDENING = ("speed", "displacement"), 30.0
"""Axes from zero on, and the last bin over the first from which a linear one would hide the first bins."""
SMALLEST_NM = 0.001
"""Least height of a panel without any residual. [N m]"""


class Row(NamedTuple):
    """A row of the figure: a joint and what is shown of it, before and after; None where there is nothing.

    Where an effect has an axis of its own, the profiles drawn are those along it.
    """

    joint: JointDiscrepancy
    before: Profile | None
    after: Profile | None
    own: OwnAxis | None = None


class Mark(NamedTuple):
    """How a direction of motion is drawn."""

    name: str
    marker: str
    colour: str


FORWARDS_MARK = Mark("forwards", ">", FORWARDS)
BACKWARDS_MARK = Mark("backwards", "<", BACKWARDS)


def draw_residual(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, a pair of panels per axis on which something shows, or every joint on a sheet.

    The sheet shows the axis of the strongest effect alone.
    """
    with figure_style():
        joints = chosen_joints(found, joint)
        rows = [row for one in joints for row in (rows_of(one) if joint is not None else rows_of(one)[:1])]
        figure, pairs = _pairs(rows, sheet=joint is None)
        handles = [handle for panels, row in zip(pairs, rows, strict=True) for handle in _draw_row(panels, row)]
        add_legend(figure, once(handles))
        figure.supylabel(f"Residual{_corner(rows)} [N m]", fontsize=7.5)
        return figure


def _pairs(rows: Sequence[Row], *, sheet: bool) -> "tuple[Figure, list[list[Axes]]]":
    """Return two panels per row: side by side on a sheet, above each other in a column where there is an after."""
    if sheet:
        figure = new_figure(SHEET_IN, HEAD_IN + SHEET_ROW_IN * len(rows))
        return figure, figure.subplots(len(rows), 2, squeeze=False, sharey="row").tolist()
    count = [1 if row.after is None else 2 for row in rows]
    figure = new_figure(COLUMN_IN, HEAD_IN + PANEL_IN * sum(count))
    panels = iter(figure.subplots(sum(count), 1, squeeze=False).ravel())
    return figure, [[next(panels) for _ in range(number)] for number in count]


def rows_of(joint: JointDiscrepancy) -> list[Row]:
    """Return one row per axis on which a named effect shows itself, and one for what is left unexplained."""
    axes: dict[str, tuple[str, OwnAxis | None]] = {}
    for effect in added(joint):
        own = None if joint.traces is None else own_axis(effect, joint.traces)
        axes.setdefault(effect.curve.axis if own is None else own.label, (effect.curve.axis, own))
    rows = [
        Row(joint, profile_along(joint.profiles, axis), profile_along(joint.remaining, axis), own)
        for axis, own in axes.values()
    ]
    if joint.verdict == "unexplained" and added(joint) and joint.remaining:
        left = joint.remaining[0]
        rows.append(Row(joint, profile_along(joint.profiles, left.axis), left))
    return rows or [Row(joint, joint.profiles[0] if joint.profiles else None, None)]


def _corner(rows: Sequence[Row]) -> str:
    corners = {row.joint.traces.corner_hz for row in rows if row.joint.traces is not None}
    return f" below {' to '.join(f'{hz:.3g}' for hz in sorted({min(corners), max(corners)}))} Hz" if corners else ""


def _draw_row(panels: "Sequence[Axes]", row: Row) -> "list[Artist]":
    joint, traces = row.joint, row.joint.traces
    for axes in panels[1:] if row.after is None else ():
        axes.set_axis_off()
    if row.before is None or traces is None:
        return say_why(panels[0], joint_name(joint), joint)
    residuals = (traces.measured - traces.before, traces.measured - traces.after)
    if row.own is not None:
        before, after = (own_profile(row.own, traces, residual) for residual in residuals)
        row = row._replace(before=before, after=after)
    titles = (f"{joint_name(joint)}: {declared_name(joint)}", grown_name(joint))
    drawn = [(residual, one) for residual, one in zip(residuals, (row.before, row.after), strict=True) if one]
    limits = np.array([limits_for(residual, one) for residual, one in drawn])
    handles: list[Artist] = []
    for axes, profile, residual, title in zip(panels, (row.before, row.after), residuals, titles, strict=False):
        if profile is not None:
            along = traces.along[profile.axis] if row.own is None else row.own.values
            handles += draw_profile(axes, profile, along, traces.dq, residual)
            # What is left needs no place unless it is more than noise.
            told = joint.verdict == "unexplained" or (profile is row.before and added(joint))
            _label(axes, title, profile.where if told else "", profile)
            axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())
    return handles


def _label(axes: "Axes", title: str, where: str, profile: Profile) -> None:
    """Name the panel and its axis, and say where along it model and measurement disagree."""
    characters = NARROW if is_narrow(axes.get_figure(root=True)) else WIDE
    lines = [fill(text, characters) for text in (title, where) if text]
    label_panel(axes, "\n".join(lines), across=4)
    name_axis(axes, profile)


def limits_for(rows: Float, profile: Profile) -> tuple[float, float]:
    """Return limits that hold zero, all means with their errors, and of the rows as much as is near. [N m]

    Args:
        rows: What is drawn of every row, shape (m,). [N m]
        profile: The means.
    """
    means = np.concatenate([profile.forwards, profile.backwards])
    half = STANDARD_ERRORS * np.nan_to_num(np.concatenate([profile.forwards_se, profile.backwards_se]))
    low, high = float(np.nanmin(means - half, initial=0.0)), float(np.nanmax(means + half, initial=0.0))
    reach = max(high - low, SMALLEST_NM)
    bottom, top = np.quantile(rows, (OUTSIDE, 1.0 - OUTSIDE))
    bottom, top = min(low, max(float(bottom), low - NEAR * reach)), max(high, min(float(top), high + NEAR * reach))
    return bottom - MARGIN * (top - bottom), top + MARGIN * (top - bottom)


def draw_profile(axes: "Axes", profile: Profile, along: Float, dq: Float, residual: Float) -> "list[Artist]":
    """Draw single rows as dots and the means of the bins with their errors, each direction; return legend entries.

    Args:
        axes: The panel.
        profile: Means of the bins.
        along: The quantity of the axis, of every row, shape (m,).
        dq: Velocity of every row, shape (m,). [rad/s]
        residual: What is drawn of every row, shape (m,). [N m]
    """
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    _draw_dots(axes, along, dq, residual)
    return [
        _draw_means(axes, profile, profile.forwards, profile.forwards_se, FORWARDS_MARK),
        _draw_means(axes, profile, profile.backwards, profile.backwards_se, BACKWARDS_MARK),
    ]


def name_axis(axes: "Axes", profile: Profile) -> None:
    """Name the axis, and let it be logarithmic beyond its first bin where the bins are of very different widths."""
    from matplotlib.ticker import FuncFormatter

    axes.set_xlabel(profile.label[:1].upper() + profile.label[1:])
    first, last = float(profile.centre[0]), float(profile.centre[-1])
    if profile.axis in STRETCHED and last > WIDENING * first > 0.0:
        axes.set_xscale("symlog", linthresh=10.0 ** np.floor(np.log10(first)), linscale=0.3)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_xlim(0.0, float(profile.edges[-1]))


def _draw_dots(axes: "Axes", along: Float, dq: Float, residual: Float) -> None:
    """Draw single rows, thinned, in the colour of their direction."""
    for which, colour in ((dq > 0, FORWARDS), (dq <= 0, BACKWARDS)):
        kept = every_nth(int(which.sum()), MOST_DOTS)
        axes.plot(along[which][kept], residual[which][kept], ".", color=colour, ms=1.2, mew=0, alpha=0.35, zorder=2)


def _draw_means(axes: "Axes", profile: Profile, mean: Float, error: Float, mark: Mark) -> "Artist":
    """Draw the mean of each bin, how far the bin reaches, and how certain the mean is."""
    reach = np.stack([profile.centre - profile.edges[:-1], profile.edges[1:] - profile.centre])
    axes.errorbar(profile.centre, mean, xerr=reach, fmt="none", elinewidth=0.6, ecolor=mark.colour, zorder=3)
    half = STANDARD_ERRORS * np.where(np.isfinite(error), error, 0.0)
    label = f"{mark.name}: mean ± {STANDARD_ERRORS:g} SE"
    return axes.errorbar(
        profile.centre, mean, half, fmt=mark.marker, color=mark.colour, ms=3.2, mec=BORDER, mew=0.4, elinewidth=0.8,
        ecolor=BORDER, capsize=1.2, label=label, zorder=4,
    )  # type: ignore[return-value]  # fmt: skip
