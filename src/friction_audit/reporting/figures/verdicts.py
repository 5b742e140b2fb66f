"""Diagnosis -> the residual after each effect."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.reporting.diagnosis_words import joint_message, plain_names
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures.style import FITTED, GREEN, MUTED, SHADE, figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from friction_audit.pipeline import Diagnosis

NOMINAL, AUGMENTED = FITTED, GREEN


def write_verdict(axes: "Axes", joint: JointDiagnosis) -> None:
    """Fill a panel with the verdict on a joint that has nothing to draw there."""
    parts.label_panel(axes, parts.joint_title(joint.joint, joint.name))
    sentence = plain_names(f"{joint.verdict.replace('_', ' ')}: {joint_message(joint).partition(';')[0]}")
    parts.write_message(axes, sentence, characters=52 if parts.is_narrow(axes) else 36, instead=True)


def _name_rows(axes: "Axes", names: Sequence[str]) -> None:
    """Name the rows of a panel, the first on top."""
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", length=0)


ROOM = 1.22  # width of a panel over its longest bar, for the number at its end


@figure_style()
def draw_ladder(found: "Diagnosis", joint: parts.Numbers) -> "Figure":
    """Draw the residual after each effect of one joint at column width, or of every joint tested on a sheet."""
    joints, sheet, note = parts.choose(found.discrepancy.joints, joint, lambda one: one.ladder, "not testable")
    heights = [0.45 + 0.21 * max(len(one.ladder), 3) for one in joints]
    figure, panels = parts.grid(heights, sheet=sheet, across=2, head_in=0.75)
    for axes, one in zip(panels, joints, strict=True):
        _draw_steps(axes, one)
    figure.supxlabel(f"Residual torque on held-out cycles, rms [N m]{note}")
    return figure


def draw_panel(axes: "Axes", found: "Diagnosis", joint: int) -> None:
    """Draw the residual after each effect of one joint into axes, and name them."""
    (one,) = parts.chosen_joints(found.discrepancy.joints, joint)
    _draw_steps(axes, one)
    axes.set_xlabel("Residual torque on held-out cycles, rms [N m]")


def _draw_steps(axes: "Axes", joint: JointDiagnosis) -> None:
    """Draw a bar per step, the largest on top, and a line at the noise floor."""
    if not joint.ladder or joint.gap is None:
        write_verdict(axes, joint)
        return
    steps = [plain_names(label) for label, _ in joint.ladder[1:-1]]
    values = [value for _, value in joint.ladder]
    places, last = np.arange(len(values)), len(values) - 1
    colours = [NOMINAL, *(AUGMENTED for _ in steps), SHADE]
    axes.barh(places, values, height=0.66, color=colours, edgecolor=MUTED, lw=0.4)
    axes.axvline(values[last], color=MUTED, lw=0.7, ls=":")
    for place, value in zip(places, values, strict=True):
        axes.annotate(f"{value:.3g}", (value, place), (2, 0), textcoords="offset points", va="center", fontsize=6.5)
    parts.label_panel(axes, f"{parts.joint_title(joint.joint, joint.name)}: {explained_words(joint)}", across=4)
    _name_rows(axes, ["nominal model", *steps, "noise floor"])
    axes.set_xlim(0.0, ROOM * max(values))


def explained_words(joint: JointDiagnosis) -> str:
    """Return the share explained of what is above the noise floor, on how many cycles, and without what."""
    gap = joint.gap
    assert gap is not None
    contacts = ", contacts left out" if len(joint.added) < len(joint.effects) else ""
    cycles = f"on {gap.cycles} held-out cycles{contacts}"
    if not joint.added:
        return f"nothing added\n{cycles}"
    if np.isnan(gap.shrink):
        return f"at the noise floor from the start\n{cycles}"
    error = f" ± {100 * gap.shrink_se:.1f}" if np.isfinite(gap.shrink_se) else ""
    return f"{100 * gap.shrink:.1f}{error} % explained\n{cycles}"
