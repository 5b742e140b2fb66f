"""The evidence of rival names: how much worse every other candidate does in the place of a named effect."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.audit import Diagnosis
from friction_audit.discrepancy.result import Effect, Evidence, JointDiscrepancy, others_of
from friction_audit.report.figures.diagnose_look import (
    GROWN,
    chosen_joints,
    draw_grid,
    joint_name,
    say_instead,
    say_why,
)
from friction_audit.report.figures.layout import add_legend, is_narrow, label_panel
from friction_audit.report.figures.style import BORDER, FITTED, MUTED, figure_style

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME_IN, TITLE_IN, LINE_IN, EMPTY_IN = 0.17, 0.45, 0.14, 0.9
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
            panels += [partial(_draw_effect, one, effect) for effect in one.effects] or [partial(_draw_nothing, one)]
            heights += [_height_in(effect, one.effects) for effect in one.effects] or [EMPTY_IN]
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
    return TITLE_IN + LINE_IN * lines + NAME_IN * len(effect.evidence) if has_rivals(effect) else EMPTY_IN


def not_drawn(effect: Effect, effects: Sequence[Effect]) -> str:
    """Return in words what an effect may be whatever the evidence: what no motion of the kind recorded tells apart."""
    drawn = {rival.name for rival in effect.evidence}
    others = [other for other in others_of(effect, effects) if other not in drawn]
    return f"nor told from {', '.join(others)}" if others else ""


def has_rivals(effect: Effect) -> bool:
    """Return whether another candidate was held against an effect; an event that comes once has none."""
    return any(rival.name != effect.name for rival in effect.evidence)


def _draw_nothing(joint: JointDiscrepancy, axes: "Axes") -> "list[Artist]":
    return say_why(axes, joint_name(joint), joint)


def _draw_effect(joint: JointDiscrepancy, effect: Effect, axes: "Axes") -> "list[Artist]":
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
