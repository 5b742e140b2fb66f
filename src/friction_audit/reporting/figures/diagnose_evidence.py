"""Each effect's own curve: what the log shows of it once all else is taken away, and the fitted effect over it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.diagnosis.result import Effect, Evidence, JointDiscrepancy, Traces, others_of
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.diagnosis_words import effect_numbers
from friction_audit.reporting.figures.diagnose_contacts import contact_panels
from friction_audit.reporting.figures.diagnose_look import (
    DASHED,
    DECLARED,
    GROWN,
    added,
    chosen_joints,
    draw_grid,
    has_contacts,
    joint_name,
    mean_along,
    own_axis,
    own_profile,
    say_instead,
    say_why,
)
from friction_audit.reporting.figures.diagnose_residual import draw_profile, limits_for, name_axis
from friction_audit.reporting.figures.style import (
    BORDER,
    FITTED,
    MUTED,
    SHADE,
    add_legend,
    figure_style,
    is_narrow,
    label_panel,
)

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


NAME_IN, TITLE_IN, LINE_IN, EMPTY_EVIDENCE_IN = 0.17, 0.45, 0.14, 0.9
NARROW, WIDE = 46, 34
"""Characters of a line of a title, at column width and on a sheet."""
ON_SHEET = 4
"""Candidates of an effect on a sheet, itself among them."""
LINEAR_TO = 10.0
"""Difference in BIC up to which the axis is linear, logarithmic beyond."""
STRONG = 6.0
"""Difference in BIC that counts as strong evidence (Kass and Raftery 1995)."""


class Mark(NamedTuple):
    """How a candidate is drawn, and what that says."""

    marker: str
    colour: str
    face: str
    label: str


CHOSEN = Mark("o", GROWN, GROWN, "the effect named")
ALIKE = Mark("o", FITTED, "white", "cannot be told apart")
BEATEN = Mark("x", BORDER, BORDER, "told apart")
ELSEWHERE = Mark("+", MUTED, MUTED, "explains something else")
"""One that does as well or better, and whose torque is another one."""


def draw_evidence(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet; a panel per effect."""
    with figure_style():
        panels: list[Callable[[Axes], list[Artist]]] = []
        heights: list[float] = []
        for one in (_nearest(one) if joint is None else one for one in chosen_joints(found, joint)):
            panels += [partial(_draw_effect_diagnose_evidence, one, effect) for effect in one.effects] or [
                partial(_draw_nothing, one)
            ]
            heights += [_height_in(effect, one.effects) for effect in one.effects] or [EMPTY_EVIDENCE_IN]
        figure, handles = draw_grid(panels, heights, sheet=joint is None)
        add_legend(figure, handles)
        figure.supxlabel("BIC above that of the effect named; r: correlation", fontsize=7.5)
        return figure


def _nearest(joint: JointDiscrepancy) -> JointDiscrepancy:
    """Return a joint with as many rivals of each effect as a sheet has room for."""
    return replace(joint, effects=tuple(replace(effect, evidence=nearest(effect)) for effect in joint.effects))


def nearest(effect: Effect, most: int = ON_SHEET) -> tuple[Evidence, ...]:
    """Return the best candidates in the place of an effect, and all that cannot be told from it."""
    ranked = enumerate(effect.evidence)
    return tuple(rival for place, rival in ranked if place < most or rival.name in effect.alone)


def _height_in(effect: Effect, effects: Sequence[Effect]) -> float:
    lines = fill(not_drawn(effect, effects), WIDE).count("\n") + 1 if not_drawn(effect, effects) else 0
    return TITLE_IN + LINE_IN * lines + NAME_IN * len(effect.evidence) if has_rivals(effect) else EMPTY_EVIDENCE_IN


def not_drawn(effect: Effect, effects: Sequence[Effect]) -> str:
    """Return in words what an effect may be whatever the evidence: what no motion of the kind recorded tells apart."""
    drawn = {rival.name for rival in effect.evidence}
    others = [other for other in others_of(effect, effects) if other not in drawn]
    return f"nor told from {', '.join(others)}" if others else ""


def has_rivals(effect: Effect) -> bool:
    """Return whether another candidate was held against an effect; an event that comes once has none."""
    return any(rival.name != effect.name for rival in effect.evidence)


def _draw_effect_diagnose_evidence(joint: JointDiscrepancy, effect: Effect, axes: "Axes") -> "list[Artist]":
    """Draw a line per candidate, the best on top; return the legend's entries."""
    if not has_rivals(effect):
        return say_instead(axes, f"{joint_name(joint)}: {effect.name}", "no other candidate was held against it")
    handles: list[Artist] = []
    axes.set_xscale("symlog", linthresh=LINEAR_TO, linscale=1.0)
    handles.append(axes.axvline(STRONG, color=MUTED, lw=0.7, ls=":", label=f"strong evidence ({STRONG:g})"))
    for place, rival in enumerate(effect.evidence):
        mark = mark_of(effect, rival)
        axes.hlines(place, 0.0, rival.delta_bic, color=MUTED, lw=0.5)
        handles += axes.plot(
            rival.delta_bic,
            place,
            mark.marker,
            color=mark.colour,
            mfc=mark.face,
            ms=4,
            mew=1.0,
            ls="",
            label=mark.label,
        )
        if place:
            axes.annotate(
                f"r = {rival.correlation:.2f}", (1.0, place), (2, 0), xycoords=("axes fraction", "data"),
                textcoords="offset points", va="center", fontsize=6.5, color=MUTED,
            )  # fmt: skip
    characters = NARROW if is_narrow(axes.get_figure(root=True)) else WIDE
    lines = (f"{joint_name(joint)}: {effect.name}", fill(not_drawn(effect, joint.effects), characters))
    label_panel(axes, "\n".join(filter(None, lines)))
    _scale(axes, effect)
    return handles


def _scale(axes: "Axes", effect: Effect) -> None:
    """Name the lines, and reach from the effect itself to the last rival."""
    from matplotlib.ticker import FuncFormatter, SymmetricalLogLocator

    worse = np.array([rival.delta_bic for rival in effect.evidence])
    axes.set_xlim(min(-2.0, 1.6 * float(worse.min())), 1.6 * max(float(worse.max()), LINEAR_TO))
    axes.xaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=LINEAR_TO))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_yticks(range(len(effect.evidence)), [rival.name for rival in effect.evidence])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(effect.evidence) - 0.5, -0.5)


def mark_of(effect: Effect, rival: Evidence) -> Mark:
    """Return how a candidate in the place of an effect is marked."""
    if rival.name == effect.name:
        return CHOSEN
    if rival.name in effect.alone:
        return ALIKE
    return ELSEWHERE if rival.delta_bic < STRONG else BEATEN


STEP_IN = 0.21
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
