"""What the figures of a diagnosis share: colours of models and directions, words for verdicts, grids of panels."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.diagnosis.profiles import bin_means
from friction_audit.diagnosis.result import Effect, JointDiscrepancy, Profile, Traces, others_of
from friction_audit.diagnosis.shown_along import shows_along
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.figures.style import (
    COLUMN_IN,
    DISSIPATED,
    FITTED,
    SHEET_IN,
    is_narrow,
    joint_title,
    label_panel,
    new_figure,
    say_in_panel,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


DECLARED = FITTED
GROWN = "#009e73"
FORWARDS = "#0072b2"
BACKWARDS = DISSIPATED
DASHED = (0, (4, 1.5))
HEAD_IN = 0.75
"""Height of a legend and the label below. [in]"""
MOST_DOTS = 1500
"""Single rows in a panel above which they would only be a blot."""
STANDARD_ERRORS = 2.0
"""Half length of an error bar, in standard errors of the mean: about 95 %."""


def chosen_joints(found: Diagnosis, joint: int | None) -> tuple[JointDiscrepancy, ...]:
    """Return one joint, given by its number for people, or with None all of them.

    Raises:
        UsageError: If the result does not hold that joint.
    """
    joints = found.discrepancy.joints
    chosen = tuple(one for one in joints if joint in (None, one.joint))
    if not chosen:
        held = ", ".join(str(one.joint) for one in joints)
        raise UsageError(f"joint {joint}: not in this result, which holds {held}; choose one of them")
    return chosen


def joint_name(joint: JointDiscrepancy) -> str:
    """Return what a panel calls a joint."""
    return joint_title(joint.joint, joint.name)


def added(joint: JointDiscrepancy) -> tuple[Effect, ...]:
    """Return the effects that the grown model has; contacts are in no model, their rows are left out."""
    return tuple(effect for effect in joint.effects if effect.name != CONTACT.name)


def has_contacts(joint: JointDiscrepancy) -> bool:
    """Return whether rows of contacts were left out."""
    return len(added(joint)) < len(joint.effects)


def declared_name(joint: JointDiscrepancy) -> str:
    """Return what the declared model is called above a panel without the rows of contacts."""
    return "declared model, contacts left out" if has_contacts(joint) else "declared model"


def grown_name(joint: JointDiscrepancy) -> str:
    """Return what the grown model is called: by what was added."""
    return "with " + " and ".join(effect.name for effect in added(joint))


def names_of(effect: Effect, effects: Sequence[Effect]) -> str:
    """Return the name of one of some effects, and what the log does not tell from it."""
    return " or ".join((effect.name, *others_of(effect, effects)))


def verdict_words(joint: JointDiscrepancy) -> str:
    """Return a verdict as people say it, with the names it gives."""
    word = joint.verdict.replace("_", " ")
    named = " and ".join(names_of(effect, joint.effects) for effect in joint.effects)
    if joint.verdict == "unexplained":
        return f"{word}, beside {named}" if named else word
    return f"{word}: {named}" if named else word


def profile_along(profiles: Sequence[Profile], axis: str) -> Profile | None:
    """Return the profile along an axis, or None."""
    return next((profile for profile in profiles if profile.axis == axis), None)


def draw_grid(
    panels: "Sequence[Callable[[Axes], list[Artist]]]", heights: Sequence[float], *, sheet: bool, across: int = 2
) -> "tuple[Figure, list[Artist]]":
    """Draw panels above each other at column width, or side by side on a sheet.

    Args:
        panels: Each draws one panel and returns the legend's entries.
        heights: Height of each panel. [in]
        sheet: If True, a page wide.
        across: Panels side by side on a sheet.

    Returns:
        The figure, and each entry of the legend once.
    """
    columns = min(across, len(panels)) if sheet else 1
    ratios = [max(heights[k : k + columns]) for k in range(0, len(panels), columns)]
    figure = new_figure(SHEET_IN if sheet else COLUMN_IN, HEAD_IN + sum(ratios))
    grid = figure.subplots(len(ratios), columns, squeeze=False, gridspec_kw={"height_ratios": ratios}).ravel()
    handles = [handle for axes, draw in zip(grid, panels, strict=False) for handle in draw(axes)]
    for axes in grid[len(panels) :]:
        axes.remove()
    return figure, once(handles)


def once(handles: "Sequence[Artist]") -> "list[Artist]":
    """Return the entries of a legend, each label once, in the order in which they came."""
    return list({str(handle.get_label()): handle for handle in reversed(handles)}.values())[::-1]


def say_why(axes: "Axes", title: str, joint: JointDiscrepancy) -> "list[Artist]":
    """Fill a panel with the verdict of a joint that has nothing to draw there."""
    return say_instead(axes, title, f"{joint.verdict.replace('_', ' ')}: {joint.message.partition(';')[0]}")


def say_instead(axes: "Axes", title: str, sentence: str) -> "list[Artist]":
    """Fill a panel that has nothing to draw with a sentence; it adds nothing to the legend."""
    label_panel(axes, title)
    axes.set_xticks([])
    axes.set_yticks([])
    say_in_panel(axes, sentence, characters=52 if is_narrow(axes.get_figure(root=True)) else 36)
    return []


ORDER = "ripple_order"
"""Parameter of an effect that repeats with the position: its waves per revolution."""
OF_SEVERAL_JOINTS = ("inertial_coupling", "torque_crosstalk")
"""Effects that follow several joints at once."""
SOURCE = "gravity_error_source"
"""Parameter of an effect that does too, unless it is 0: the joint's own angle."""
POINTS = 60
"""Stretches of the axis, with equally many rows each, over which a torque is averaged for a line."""
BINS = 12


class OwnAxis(NamedTuple):
    """A quantity of every row, shape (m,), and what the axis is called."""

    label: str
    values: Float


def own_axis(effect: Effect, traces: Traces) -> OwnAxis | None:
    """Return what the effect is drawn along; None where the axis of its curve shows it.

    A ripple is drawn over one wave, for bins in place would average it away. What follows several joints, or is no
    curve over its axis, as the ringing of a spring, is drawn over the torque that was fitted: on the diagonal, all that
    it says is in the log.
    """
    if ORDER in effect.parameters:
        waves = effect.parameters[ORDER].value * traces.q / (2 * np.pi)
        return OwnAxis("Position within a wave [waves]", np.mod(waves, 1.0))
    source = effect.parameters.get(SOURCE)
    alone = effect.name not in OF_SEVERAL_JOINTS and (source is None or source.value == 0.0)
    if alone and shows_along(effect.torque, traces.along[effect.curve.axis], traces.dq):
        return None
    return OwnAxis(f"Fitted torque of {effect.name} [N m]", effect.torque)


def own_profile(own: OwnAxis, traces: Traces, torque: Float) -> Profile:
    """Return the means of a torque over an axis of an effect's own, in bins of equal width.

    Args:
        own: The axis.
        traces: The rows of the joint.
        torque: Of every row, shape (m,). [N m]
    """
    edges = np.linspace(own.values.min(), own.values.max(), BINS + 1)
    bins = np.clip(np.searchsorted(edges, own.values, side="right") - 1, 0, BINS - 1)
    forwards, forwards_se = bin_means(torque, bins, traces.cycle, traces.dq > 0, BINS)
    backwards, backwards_se = bin_means(torque, bins, traces.cycle, traces.dq <= 0, BINS)
    return Profile(
        axis=own.label,
        label=own.label,
        edges=edges,
        centre=0.5 * (edges[:-1] + edges[1:]),
        forwards=forwards,
        backwards=backwards,
        forwards_se=forwards_se,
        backwards_se=backwards_se,
        share=float("nan"),
        p_value=float("nan"),
        where="",
    )


def mean_along(along: Float, torque: Float, points: int = POINTS) -> tuple[Float, Float]:
    """Return the mean of both over stretches of the axis with equally many rows.

    Args:
        along: The quantity of the axis, shape (m,).
        torque: Shape (m,). [N m]
        points: Stretches at most.
    """
    order = np.argsort(along, kind="stable")
    parts = [part for part in np.array_split(order, points) if len(part)]
    return np.array([along[part].mean() for part in parts]), np.array([torque[part].mean() for part in parts])
