"""All joints at a glance: the verdict of each, and its gap before, after, and at the floor of the noise."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.audit import Diagnosis
from friction_audit.discrepancy.result import UNANSWERED, JointDiscrepancy
from friction_audit.report.figures.diagnose_look import DECLARED, GROWN, chosen_joints, joint_name, once, verdict_words
from friction_audit.report.figures.layout import add_legend, label_panel, new_figure
from friction_audit.report.figures.style import BORDER, COLUMN_IN, MUTED, SHEET_IN, figure_style

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEAD_IN, ROW_IN = 0.8, 0.34
CHARACTERS = {COLUMN_IN: 30, SHEET_IN: 64}
"""Characters of a line of the verdict, by the width of the figure."""
MOST_LINES = 3
WIDER = 1.3
"""Times the largest and the smallest torque up to which the axis reaches."""


class Mark(NamedTuple):
    """How a torque is drawn, and what it is."""

    marker: str
    colour: str
    face: str
    size: float
    label: str


DECLARED_MARK = Mark("D", DECLARED, DECLARED, 4.0, "declared model")
GROWN_MARK = Mark("o", GROWN, GROWN, 4.0, "with the effects named")
FLOOR_MARK = Mark("|", BORDER, BORDER, 9.0, "floor of the noise")
LIMIT_MARK = Mark("^", MUTED, "white", 3.5, "detection limit")


def draw_verdicts(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet, a line for each."""
    with figure_style():
        joints = chosen_joints(found, joint)
        figure = new_figure(COLUMN_IN if joint is not None else SHEET_IN, HEAD_IN + ROW_IN * max(len(joints), 2))
        axes, words = figure.subplots(1, 2, sharey=True, gridspec_kw={"width_ratios": (1.0, 1.0)})
        handles = [handle for place, one in enumerate(joints) for handle in _draw_joint(axes, place, one)]
        _scale(axes, joints)
        _write(words, joints, CHARACTERS[figure.get_figwidth()])
        add_legend(figure, once(handles))
        return figure


def _draw_joint(axes: "Axes", place: int, joint: JointDiscrepancy) -> "list[Artist]":
    """Draw a line from the gap of the declared model to that of the grown one; return the legend's entries."""
    if joint.gap is None:
        return []
    gap = joint.gap
    axes.hlines(place, gap.after, gap.before, color=MUTED, lw=0.8, zorder=2)
    points = [(DECLARED_MARK, gap.before), (FLOOR_MARK, gap.floor)]
    points += [(GROWN_MARK, gap.after)] if joint.effects else []
    points += [(LIMIT_MARK, joint.detection_limit_nm)] if np.isfinite(joint.detection_limit_nm) else []
    handles: list[Artist] = []
    for mark, value in points:
        handles += axes.plot(
            value, place, mark.marker, color=mark.colour, mfc=mark.face, ms=mark.size, mew=0.9, label=mark.label
        )
    return handles


def _scale(axes: "Axes", joints: Sequence[JointDiscrepancy]) -> None:
    """Name the joints, and let a logarithmic axis hold all that is drawn."""
    gaps = [(one.gap.before, one.gap.after, one.gap.floor, one.detection_limit_nm) for one in joints if one.gap]
    values = np.array(gaps).ravel()
    values = values[np.isfinite(values) & (values > 0.0)]
    label_panel(axes, "")
    axes.set_ylim(len(joints) - 0.5, -0.5)
    axes.set_yticks(range(len(joints)), [joint_name(one) for one in joints])
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("Torque on locked cycles, rms [N m]")
    if not len(values):
        axes.set_xticks([])
        return
    axes.set_xscale("log")
    axes.set_xlim(float(values.min()) / WIDER, float(values.max()) * WIDER)
    _few_ticks(axes)


def _few_ticks(axes: "Axes") -> None:
    """Write plain numbers at 1 and 3 times the powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="x", color=MUTED, lw=0.25, alpha=0.5)


def _write(axes: "Axes", joints: Sequence[JointDiscrepancy], characters: int) -> None:
    """Write what is said of each joint beside its line."""
    axes.set_axis_off()
    for place, joint in enumerate(joints):
        text = fill(said_of(joint), characters, max_lines=MOST_LINES, placeholder=" ...")
        axes.annotate(text, (0.0, place), xycoords=("axes fraction", "data"), va="center", fontsize=6.5)


def said_of(joint: JointDiscrepancy) -> str:
    """Return the verdict and names, and where there is no answer, the message."""
    words = verdict_words(joint)
    return f"{words}: {joint.message}" if joint.verdict in UNANSWERED else words
