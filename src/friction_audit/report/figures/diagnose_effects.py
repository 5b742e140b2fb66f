"""Each effect's own curve: what the log shows of it once all else is taken away, and the fitted effect over it."""

from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING

from friction_audit.audit import Diagnosis
from friction_audit.discrepancy.candidates.contact_event import CANDIDATE as CONTACT
from friction_audit.discrepancy.result import Effect, JointDiscrepancy, Traces
from friction_audit.joint_log import Float
from friction_audit.report.diagnose_table import effect_numbers
from friction_audit.report.figures.diagnose_contacts import contact_panels
from friction_audit.report.figures.diagnose_look import DASHED, chosen_joints, draw_grid, joint_name, say_why
from friction_audit.report.figures.diagnose_own_axis import mean_along, own_axis, own_profile
from friction_audit.report.figures.diagnose_residual import draw_profile, limits_for, name_axis
from friction_audit.report.figures.layout import add_legend, is_narrow, label_panel
from friction_audit.report.figures.style import BORDER, MUTED, figure_style

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL_IN, SHEET_PANEL_IN, EMPTY_IN = 2.3, 1.55, 0.9
ACROSS = 3
CHARACTERS = 56
"""Of a line below a panel."""
BELOW_PT = 28.0


def draw_effects(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, parameters below, or every joint on a sheet; a panel per effect."""
    with figure_style():
        panels: list[Callable[[Axes], list[Artist]]] = []
        heights: list[float] = []
        for one in chosen_joints(found, joint):
            drawn = [panel for effect in one.effects for panel in _panels(found, one, effect, sheet=joint is None)]
            panels += drawn or [partial(_draw_nothing, one)]
            heights += [SHEET_PANEL_IN if joint is None else PANEL_IN for _ in drawn] or [EMPTY_IN]
        figure, handles = draw_grid(panels, heights, sheet=joint is None, across=ACROSS)
        add_legend(figure, handles)
        figure.supylabel("Torque of the effect [N m]", fontsize=7.5)
        return figure


def _panels(
    found: Diagnosis, joint: JointDiscrepancy, effect: Effect, *, sheet: bool
) -> "list[Callable[[Axes], list[Artist]]]":
    if effect.name == CONTACT.name:
        return contact_panels(found, joint, effect, sheet=sheet)
    return [partial(_draw_effect, joint, effect)]


def _draw_nothing(joint: JointDiscrepancy, axes: "Axes") -> "list[Artist]":
    return say_why(axes, joint_name(joint), joint)


def _draw_effect(joint: JointDiscrepancy, effect: Effect, axes: "Axes") -> "list[Artist]":
    """Draw the effect as the log shows it, and as it was fitted; return the legend's entries."""
    traces = joint.traces
    assert traces is not None
    shown = traces.measured - traces.after + effect.torque
    label_panel(axes, f"{joint_name(joint)}: {effect.name}")
    own = own_axis(effect, traces)
    along = traces.along[effect.curve.axis] if own is None else own.values
    curve = effect.curve if own is None else own_profile(own, traces, shown)
    handles = draw_profile(axes, curve, along, traces.dq, shown)
    handles += _draw_fitted(axes, traces, effect, along)
    axes.set_ylim(*limits_for(shown, curve))
    name_axis(axes, curve)
    if is_narrow(axes.get_figure(root=True)):
        _tell(axes, effect_numbers(effect))
    return handles


def _tell(axes: "Axes", sentence: str) -> None:
    """Write a sentence below the panel and its label."""
    axes.annotate(
        fill(sentence, CHARACTERS), (0.0, 0.0), (0.0, -BELOW_PT), xycoords="axes fraction",
        textcoords="offset points", va="top", fontsize=6.0, color=MUTED,
    )  # fmt: skip


def _draw_fitted(axes: "Axes", traces: Traces, effect: Effect, along: Float) -> "list[Artist]":
    """Draw the fitted torque along the axis, a line for each direction."""
    handles: list[Artist] = []
    for which, dashes, name in ((traces.dq > 0, "-", "forwards"), (traces.dq <= 0, DASHED, "backwards")):
        x, y = mean_along(along[which], effect.torque[which])
        handles += axes.plot(x, y, color=BORDER, lw=0.9, ls=dashes, label=f"fitted, {name}", zorder=5)
    return handles
