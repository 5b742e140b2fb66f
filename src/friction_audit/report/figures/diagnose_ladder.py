"""The ladder of gaps: what the declared model leaves, what is left after each effect, and the floor of the noise."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.audit import Diagnosis
from friction_audit.discrepancy.candidates.contact_event import CANDIDATE as CONTACT
from friction_audit.discrepancy.result import JointDiscrepancy
from friction_audit.report.figures.diagnose_look import (
    DECLARED,
    GROWN,
    added,
    chosen_joints,
    draw_grid,
    has_contacts,
    joint_name,
    say_why,
)
from friction_audit.report.figures.layout import label_panel
from friction_audit.report.figures.style import MUTED, SHADE, figure_style

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEP_IN, TITLE_IN = 0.21, 0.45
LEFT_OUT = "contacts left out"
ROOM = 1.22
"""Width of a panel over its longest bar, for the number behind the bar."""


def draw_ladder(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet."""
    with figure_style():
        joints = chosen_joints(found, joint)
        heights = [TITLE_IN + STEP_IN * max(len(one.ladder), 3) for one in joints]
        figure, _ = draw_grid([partial(_draw_joint, one) for one in joints], heights, sheet=joint is None)
        figure.supxlabel("Residual torque on locked cycles, rms [N m]", fontsize=7.5)
        return figure


def _draw_joint(joint: JointDiscrepancy, axes: "Axes") -> "list[Artist]":
    """Draw a bar per step, the largest on top, and a line at the floor."""
    if not joint.ladder or joint.gap is None:
        return say_why(axes, joint_name(joint), joint)
    labels, values = zip(*joint.ladder, strict=True)
    labels = tuple(LEFT_OUT if label == f"+ {CONTACT.name}" else label for label in labels)
    places, last = np.arange(len(values)), len(values) - 1
    colours = [SHADE if k == last else DECLARED if k == 0 else GROWN for k in places]
    axes.barh(places, values, height=0.66, color=colours, edgecolor=MUTED, lw=0.4)
    axes.axvline(values[last], color=MUTED, lw=0.7, ls=":")
    for place, value in zip(places, values, strict=True):
        axes.annotate(f"{value:.4f}", (value, place), (2, 0), textcoords="offset points", va="center", fontsize=6.5)
    label_panel(axes, f"{joint_name(joint)}: {closed_words(joint)}", across=4)
    axes.set_yticks(places, labels)
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(last + 0.6, -0.6)
    axes.set_xlim(0.0, ROOM * max(values))
    return []


def closed_words(joint: JointDiscrepancy) -> str:
    """Return how much of what can be closed was closed, on how many cycles, and without what."""
    gap = joint.gap
    assert gap is not None
    cycles = f"on {gap.cycles} locked cycles{f', {LEFT_OUT}' if has_contacts(joint) else ''}"
    if not added(joint):
        return f"nothing added\n{cycles}"
    if np.isnan(gap.shrink):
        return f"at the floor from the start\n{cycles}"
    error = f" ± {100 * gap.shrink_se:.1f}" if np.isfinite(gap.shrink_se) else ""
    return f"{100 * gap.shrink:.1f}{error} % closed\n{cycles}"
