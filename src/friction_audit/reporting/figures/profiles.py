"""Diagnosis -> residuals along the quantity that shows an effect and by effect, effect curves, contact events."""

from collections.abc import Sequence
from dataclasses import replace
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from friction_audit.diagnosis.residual_checks import ORDER
from friction_audit.diagnosis.result import CONTACT_EVENT, JointDiagnosis, NamedEffect, OwnAxis, Profile
from friction_audit.effects.registry import GRAVITY
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.diagnosis_words import MOST_NUMBERS, effect_numbers, joint_message, plain_names
from friction_audit.reporting.figures import panels as parts, style as theme
from friction_audit.reporting.words import enumerate_words, range_of

NOMINAL, AUGMENTED = theme.FITTED, theme.GREEN
CHARACTERS = 52  # of a line of a title
OUTSIDE = 0.005  # share of the samples that may lie above a panel, and below
NEAR = 1.5  # more where they are farther from the means than so many times their range
SMALLEST_NM = 0.001  # least height of a panel without any residual
STANDARD_ERRORS = 2.0  # half length of an error bar: about 95 %
MOST_DOTS = 1500  # samples in a panel above which they would only be a blot
# Axes from zero on, and the last bin over the first from which a linear one would hide the first bins.
STRETCHED, WIDENING = ("speed", "displacement"), 30.0
POINTS = 30  # stretches with equally many samples over which a fitted torque is averaged for a line


class Row(NamedTuple):
    """The residual of a joint along an axis, before and after; None where there is nothing."""

    before: Profile | None
    after: Profile | None
    own: OwnAxis | None = None


def _own_axis(effect: NamedEffect) -> OwnAxis | None:
    """A ripple is drawn over its wave, gravity that no angle shows over its fitted torque; no other effect is."""
    return effect.own if ORDER in effect.parameters or effect.name == GRAVITY else None


def rows_of(joint: JointDiagnosis) -> list[Row]:
    """Return one row per axis that shows a named effect, and one for what is left unexplained."""

    def along(axis: str) -> Row:
        both = (joint.profiles, joint.remaining)
        before, after = (next((one for one in found if one.axis == axis), None) for found in both)
        return Row(before, after)

    rows: dict[str, Row] = {}
    for effect in joint.added:
        own = _own_axis(effect)
        row = along(effect.curve.axis) if own is None else Row(own.before, own.after, own)
        rows.setdefault(own.label if own else effect.curve.axis, row)
    found = list(rows.values())
    if joint.verdict == "unexplained" and joint.added and joint.remaining:
        found.append(along(joint.remaining[0].axis))
    return found or [Row(joint.profiles[0] if joint.profiles else None, None)]


def _draw_residual(panels: Sequence[Axes], _: Diagnosis, joint: JointDiagnosis) -> None:
    """Draw the residual before and after along every axis that shows an effect; on a sheet of the largest alone."""
    narrow, left = parts.is_narrow(panels[0]), iter(panels)
    for row in rows_of(joint) if narrow else rows_of(joint)[:1]:
        own, traces = [next(left) for _ in range(2 if row.after is not None else 1)], joint.traces
        if row.before is None or traces is None:
            write_verdict(own[0], joint)
            continue
        names = plain_names(enumerate_words(effect.name for effect in joint.added))
        contacts = ", contacts left out" if len(joint.added) < len(joint.effects) else ""
        titles = (f"{parts.joint_title(joint.joint, joint.name)}: nominal model{contacts}", f"with {names}")
        models = zip(own, titles, (row.before, row.after), (traces.before, traces.after), strict=False)
        for axes, title, profile, torque in models:
            assert profile is not None
            parts.label_panel(axes, fill(title, CHARACTERS), across=4)
            along = traces.along[profile.axis] if row.own is None else row.own.values
            draw_profile(axes, profile, along, traces.dq, traces.measured - torque)
        lows, highs = zip(*(axes.get_ylim() for axes in own), strict=True)
        for axes in own:
            axes.set_ylim(min(lows), max(highs))
    for axes in left:
        axes.set_axis_off()


def _residual_label(found: Diagnosis) -> str:
    corners = [one.traces.corner_hz for one in found.joints if one.traces is not None]
    low_pass = f", low-pass {range_of(corners, lambda hz: f'{hz:.3g}')} Hz" if corners else ""
    return f"Residual torque{low_pass} [N m]"


RESIDUAL = parts.Layout(
    joints=lambda found: found.joints, has=lambda _, joint: joint.traces is not None, lacks="not testable",
    draw=_draw_residual, height_in=(1.4, 1.55), x="", y=_residual_label,
    panels=lambda _, joint, sheet: 2 if sheet else sum(1 if row.after is None else 2 for row in rows_of(joint)),
)  # fmt: skip


def draw_profile(axes: Axes, profile: Profile, along: Float, dq: Float, torque: Float) -> None:
    """Draw samples of shape (m,) as dots over ``along`` and the means of the bins, each direction of motion apart.

    The y axis holds zero, all means with their errors, and most of the samples; the x axis is logarithmic beyond its
    first bin where the bins are of very different widths.
    """
    parts.mark_zero(axes)
    shown = [np.zeros(1)]
    reach = np.stack([profile.centre - profile.edges[:-1], profile.edges[1:] - profile.centre])
    directions = (
        ("forwards", dq > 0, ">", theme.BLUE, profile.forwards, profile.forwards_se),
        ("backwards", dq <= 0, "<", theme.DISSIPATED, profile.backwards, profile.backwards_se),
    )
    for name, which, marker, colour, mean, error in directions:
        kept = parts.every_nth(int(which.sum()), MOST_DOTS)
        axes.plot(along[which][kept], torque[which][kept], ".", color=colour, ms=1.2, mew=0, alpha=0.35, zorder=2)
        axes.errorbar(profile.centre, mean, xerr=reach, fmt="none", elinewidth=0.6, ecolor=colour, zorder=3)
        half = STANDARD_ERRORS * np.where(np.isfinite(error), error, 0.0)
        axes.errorbar(
            profile.centre, mean, half, fmt=marker, color=colour, ms=3.2, mec=theme.BORDER, mew=0.4, elinewidth=0.8,
            capsize=1.2, label=f"{name}: mean ± {STANDARD_ERRORS:g} SE", zorder=4,
        )  # fmt: skip
        shown += [mean - half, mean + half]
    most = np.quantile(torque, (OUTSIDE, 1.0 - OUTSIDE))
    axes.set_ylim(parts.limits(np.concatenate(shown), most, near=NEAR, smallest=SMALLEST_NM))
    axes.set_xlabel(profile.label[:1].upper() + profile.label[1:])
    first, last = float(profile.centre[0]), float(profile.centre[-1])
    if profile.axis in STRETCHED and last > WIDENING * first > 0.0:
        axes.set_xscale("symlog", linthresh=10.0 ** np.floor(np.log10(first)), linscale=0.3)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_xlim(0.0, float(profile.edges[-1]))


def _draw_effects(panels: Sequence[Axes], _: Diagnosis, joint: JointDiagnosis) -> None:
    """Draw a panel per effect, of contacts a second one in a column; without any effect the residual and its noise."""
    left = iter(panels)
    if not joint.effects:
        _draw_nothing_missing(next(left), joint)
    for effect in joint.effects:
        if effect.name != CONTACT_EVENT or joint.contacts is None:
            _draw_effect(next(left), joint, effect)
            continue
        t, residual, spans = joint.contacts.t, joint.contacts.residual_nm, joint.contacts.spans_s
        title = f"{parts.joint_title(joint.joint, joint.name)}: {plain_names(effect.name)}"
        _draw_contacts(next(left), joint, title, (float(t[0]), float(t[-1])))
        if parts.is_narrow(panels[0]):
            size = [np.nanmax(np.abs(residual[(t >= start) & (t <= stop)]), initial=0.0) for start, stop in spans]
            start, stop = spans[int(np.argmax(size))]
            _draw_contacts(next(left), joint, "the largest", (start - ASIDE_S, stop + ASIDE_S))


def _draw_nothing_missing(axes: Axes, joint: JointDiagnosis) -> None:
    """Draw what the nominal model leaves over the quantity that shows most of it, within the detection limit."""
    profile, traces, limit = next(iter(joint.profiles), None), joint.traces, joint.detection_limit_nm
    if profile is None or traces is None:
        write_verdict(axes, joint)
        return
    words = plain_names(joint.verdict.replace("_", " "))
    parts.label_panel(axes, f"{parts.joint_title(joint.joint, joint.name)}: {words}, no effect named", across=4)
    draw_profile(axes, profile, traces.along[profile.axis], traces.dq, traces.measured - traces.before)
    if np.isfinite(limit):
        axes.axhspan(-limit, limit, color=theme.SHADE, lw=0, zorder=0, label="below the detection limit")


def _draw_effect(axes: Axes, joint: JointDiagnosis, effect: NamedEffect) -> None:
    """Draw the effect as the log shows it, and as it was fitted, a line for each direction."""
    traces, own = joint.traces, _own_axis(effect)
    assert traces is not None
    parts.label_panel(axes, f"{parts.joint_title(joint.joint, joint.name)}: {plain_names(effect.name)}")
    curve, along = (own.curve, own.values) if own else (effect.curve, traces.along[effect.curve.axis])
    draw_profile(axes, curve, along, traces.dq, traces.measured - traces.after + effect.torque)
    for which, dashes, name in ((traces.dq > 0, "-", "forwards"), (traces.dq <= 0, theme.DASHED, "backwards")):
        x, y = mean_along(along[which], effect.torque[which])
        axes.plot(x, y, color=theme.BORDER, lw=0.9, ls=dashes, label=f"fitted, {name}", zorder=5)
    if parts.is_narrow(axes) and len(effect.parameters) <= MOST_NUMBERS:
        numbers = fill(effect_numbers(effect).replace(" ± ", "\u00a0±\u00a0"), 56)
        axes.annotate(
            numbers, (0.0, 0.0), (0.0, -28.0), xycoords="axes fraction",
            textcoords="offset points", va="top", fontsize=6.0, color=theme.MUTED,
        )  # fmt: skip


def mean_along(along: Float, torque: Float, points: int = POINTS) -> tuple[Float, Float]:
    """Return the mean of a quantity and of a torque, shape (m,) each, over stretches with equally many samples."""
    order = np.argsort(along, kind="stable")
    pieces = [part for part in np.array_split(order, points) if len(part)]
    return np.array([along[part].mean() for part in pieces]), np.array([torque[part].mean() for part in pieces])


ASIDE_S = 1.0  # what is shown before and after the largest contact
LEAST_WIDTH = 0.004  # share of a panel that a contact is drawn wide at least


def _draw_contacts(axes: Axes, joint: JointDiagnosis, title: str, ends: tuple[float, float]) -> None:
    contacts, traces = joint.contacts, joint.traces
    assert contacts is not None
    assert traces is not None
    parts.label_panel(axes, title)
    parts.mark_zero(axes)
    label = f"measured less model, below {traces.corner_hz:.3g} Hz"
    axes.plot(contacts.t, contacts.residual_nm, color=AUGMENTED, lw=0.6, label=label)
    least = LEAST_WIDTH * (ends[1] - ends[0])
    for start, stop in contacts.spans_s:
        more = 0.5 * max(least - (stop - start), 0.0)
        axes.axvspan(start - more, stop + more, fc=theme.ZOOMED, ec=theme.REJECTED, lw=0.4, zorder=0, label="contact")
    axes.set_xlim(*ends)
    axes.set_xlabel("Time [s]")


def _named(found: Diagnosis) -> bool:
    return any(one.effects for one in found.joints)


# Where no effect was named on any joint, the residuals.
EFFECTS = replace(
    RESIDUAL, lacks="no effect named", draw=_draw_effects, across=3,
    has=lambda found, joint: joint.effects or (not _named(found) and joint.traces is not None),
    panels=lambda _, joint, sheet: (
        max(len(joint.effects), 1)
        + (not sheet and joint.contacts is not None and CONTACT_EVENT in [one.name for one in joint.effects])
    ),
    height_in=lambda joint, sheet: 1.55 if sheet else 2.3 if joint.effects else 1.8,
    y=lambda found: f"{'Torque of the effect' if _named(found) else 'Residual torque'} [N m]",
)  # fmt: skip


def write_verdict(axes: Axes, joint: JointDiagnosis) -> None:
    """Fill a panel with the verdict on a joint that has nothing to draw there."""
    sentence = plain_names(f"{joint.verdict.replace('_', ' ')}: {joint_message(joint).partition(';')[0]}")
    parts.write_message(axes, sentence, characters=52 if parts.is_narrow(axes) else 36, instead=True)


ROOM = 1.22  # width of a panel over its longest bar, for the number at its end


def _draw_steps(panels: Sequence[Axes], _: Diagnosis, joint: JointDiagnosis) -> None:
    """Draw a bar per step, the largest on top, and a line at the noise floor; say how much is explained."""
    (axes,) = panels
    if not joint.ladder or joint.gap is None:
        write_verdict(axes, joint)
        return
    steps = [plain_names(label) for label, _ in joint.ladder[1:-1]]
    values = [value for _, value in joint.ladder]
    places, last = np.arange(len(values)), len(values) - 1
    colours = [NOMINAL, *(AUGMENTED for _ in steps), theme.SHADE]
    axes.barh(places, values, height=0.66, color=colours, edgecolor=theme.MUTED, lw=0.4)
    axes.axvline(values[last], color=theme.MUTED, lw=0.7, ls=":")
    for place, value in zip(places, values, strict=True):
        axes.annotate(f"{value:.3g}", (value, place), (2, 0), textcoords="offset points", va="center", fontsize=6.5)
    gap, contacts = joint.gap, ", contacts left out" if len(joint.added) < len(joint.effects) else ""
    explained = "nothing added"
    if joint.added:
        error = f" ± {100 * gap.shrink_se:.1f}" if np.isfinite(gap.shrink_se) else ""
        known = np.isfinite(gap.shrink)
        explained = f"{100 * gap.shrink:.1f}{error} % explained" if known else "at the noise floor from the start"
    title = f"{parts.joint_title(joint.joint, joint.name)}: {explained}\non {gap.cycles} held-out cycles{contacts}"
    parts.label_panel(axes, title, across=4)
    axes.set_ylim(len(values) - 0.5, -0.5)  # the first on top
    axes.set_yticks(places, ["nominal model", *steps, "noise floor"])
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(0.0, ROOM * max(values))


LADDER = replace(
    RESIDUAL, has=lambda _, joint: joint.ladder, draw=_draw_steps, panels=1, across=2, y="",
    height_in=lambda joint, _: 0.45 + 0.21 * max(len(joint.ladder), 3),
    x="Residual torque on held-out cycles, rms [N m]",
)  # fmt: skip
