"""Figures of joints, described once and drawn alike: sheets and columns, titles, messages, legends, limits, curves."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from textwrap import fill
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float, median_step
from friction_audit.preprocessing.interaction import Reason
from friction_audit.reporting.figures import style as theme
from friction_audit.reporting.figures.style import COLUMN_IN, Look, figure_style
from friction_audit.reporting.notices import text_of
from friction_audit.reporting.words import NEWTON_METRES, SHORTEST_NAME, in_unit, joint_label, joints_label

HANDLE_PT, LETTER_PT, LONGEST_FORMULA = 26.0, 3.5, 24  # room that a label of a legend takes; of formulas, less is seen
TICKS_ON_SHEET, TICKS_IN_COLUMN = 4, 6
MOST_WITH_REASON = 5  # panels of a figure: those of one joint in the replay

Joint = Any  # a part of a result that belongs to one joint, whose number it has
Drawn = TypeVar("Drawn", bound="Figure | Axes")
Numbers = int | tuple[int, ...] | None  # of one joint at column width, of the joints of a sheet, or None for all
Words = str | Callable[[Any], str]


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """A figure of the joints of a result: the panels of each joint, and what stands around them."""

    joints: Callable[[Any], Sequence[Joint]]  # of a result
    has: Callable[[Any, Joint], object]  # whether there is something to show of a joint of a result
    lacks: str  # what a joint without it has not, for the line that stands for it
    # Draws a joint of a result into its panels, the first of which has its name above.
    draw: Callable[[Sequence[Axes], Any, Joint], None]
    # Panels of a joint: below each other in a column, next to each other on a sheet (the last argument is True).
    panels: int | Callable[[Any, Joint, bool], int] = 1
    across: int | None = None  # panels side by side on a sheet; those of one joint if None
    height_in: tuple[float, float] | Callable[[Joint, bool], float] = (1.45, 2.4)  # of panels on a sheet, in a column
    head_in: float = 0.75  # height of the legend and of the label below
    x: Words  # name of the x axis of all panels
    y: Words = ""  # name of the y axis of all panels, if it is one
    shared: Any = False  # ``sharex`` of the panels
    legend: Sequence[str] = ()  # labels that stand first in the legend

    @figure_style()
    def __call__(self, result: Any, numbers: Numbers = None) -> Figure:
        """Draw one joint at column width, or those of a sheet that have something to show; one alone is no sheet."""
        drawn, note = choose(self.joints(result), numbers, partial(self.has, result), self.lacks)
        sheet, height = len(drawn) > 1, self.height_in
        counts = [self.panels if isinstance(self.panels, int) else self.panels(result, one, sheet) for one in drawn]
        each = [height(one, sheet) if callable(height) else height[0 if sheet else 1] for one in drawn]
        width, across = (theme.SHEET_IN, self.across or counts[0]) if sheet else (COLUMN_IN, 1)
        shared = self.shared if sheet or not self.shared else "all"
        figure, axes = grid(np.repeat(each, counts).tolist(), across, width, self.head_in, shared)
        panels = iter(axes)
        for one, count in zip(drawn, counts, strict=True):
            self._draw_joint([next(panels) for _ in range(count)], result, one)
        add_legend(figure, self.legend)
        figure.align_ylabels()
        x, y = (words(result) if callable(words) else words for words in (self.x, self.y))
        figure.supxlabel(f"{x}{note}".strip())
        figure.supylabel(y)
        return figure

    def into(self, axes: Axes, result: Any, number: int) -> None:
        """Draw one joint, whose one panel it is, into axes, and name them."""
        self._draw_joint([axes], result, *chosen_joints(self.joints(result), number))
        x, y = (words(result) if callable(words) else words for words in (self.x, self.y))
        axes.set(xlabel=x, ylabel=y or axes.get_ylabel())

    def _draw_joint(self, panels: Sequence[Axes], result: Any, joint: Joint) -> None:
        for axes in panels:
            label_panel(axes, joint_title(joint.joint, joint.name) if axes is panels[0] else "")
        self.draw(panels, result, joint)


def choose(
    joints: Sequence[Joint], numbers: Numbers, has: Callable[[Joint], object], lacks: str
) -> tuple[Sequence[Joint], str]:
    """Return the joints to be drawn, and a line on those that are left out because they have nothing to show."""
    if isinstance(numbers, int):
        return chosen_joints(joints, numbers), ""
    every = [one for one in joints if numbers is None or one.joint in numbers]
    shown = [one for one in every if has(one)] or every
    without = [one.joint for one in every if one not in shown]
    return shown, f"\n{joints_label(without)}: {lacks}" if without else ""


def chosen_joints(joints: Sequence[Joint], joint: int) -> Sequence[Joint]:
    """Return the joint of a number (1..n), alone; a UsageError if the result does not hold it."""
    chosen = [one for one in joints if one.joint == joint]
    if not chosen:
        held = ", ".join(str(one.joint) for one in joints)
        raise UsageError(f"joint {joint}: not in this result, which holds {held}; choose one of them")
    return chosen


def joint_title(joint: int, name: str) -> str:
    """Return what a panel of a figure calls a joint; no panel has room for more of its name."""
    return f"joint {joint_label(joint, name, SHORTEST_NAME)}"


def grid(
    heights_in: Sequence[float], across: int, width_in: float, head_in: float, sharex: Any = False, sharey: Any = False
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its panels, ``across`` of them side by side, each row as high as its highest panel."""
    count = len(heights_in)
    across = min(across, count)
    rows = [max(heights_in[k : k + across]) for k in range(0, count, across)]
    figure = Figure(figsize=(width_in, head_in + sum(rows)), layout="constrained")
    panels = figure.subplots(len(rows), across, squeeze=False, sharex=sharex, sharey=sharey, height_ratios=rows).ravel()
    for k in range(count, len(panels)):
        panels[k - across].tick_params(labelbottom=True)  # it is the lowest of its column now
        panels[k].remove()
    return figure, list(panels[:count])


def is_narrow(axes: Axes | Figure) -> bool:
    """Return True for a figure, or a panel of one, that is one column of a paper wide."""
    figure = axes.get_figure(root=True)
    return figure is not None and figure.get_figwidth() <= COLUMN_IN


def label_panel(axes: Axes, title: str = "", *, y: str | None = None, across: int | None = None) -> None:
    """Write a panel's title above its left corner and name its y axis; keep the ticks few, ``across`` of them on x."""
    axes.set_title(title, loc="left")
    if y is not None:
        axes.set_ylabel(y)
    ticks = TICKS_IN_COLUMN if is_narrow(axes) else TICKS_ON_SHEET
    for axis, most in ((axes.xaxis, across or ticks), (axes.yaxis, ticks)):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))


def write_message(
    axes: Axes, sentence: str, *, characters: int = 44, instead: bool = False, height: float = 0.5
) -> None:
    """Write a sentence, if any, into a panel, wrapped; without ticks where it stands ``instead`` of curves."""
    if not sentence:
        return
    if instead:
        axes.set_xticks([])
        axes.set_yticks([])
    box: Look = {"facecolor": "white", "edgecolor": theme.MUTED, "linewidth": 0.4, "pad": 2.5, "alpha": 0.92}
    axes.text(
        0.5, height, fill(sentence, characters), transform=axes.transAxes, ha="center", va="center", fontsize=6.5,
        color=theme.BORDER, bbox=box, zorder=10,
    )  # fmt: skip


def write_reason(axes: Axes, lack: str, reason: Reason, *, characters: int = 44) -> None:
    """Write why a result is lacking, if there is a reason, without the advice in it; on a sheet that it is lacking."""
    if len(axes.figure.axes) > MOST_WITH_REASON:  # a sentence in each small panel would cover what it shows
        write_message(axes, lack if reason else "", height=0.94)
        return
    write_message(axes, f"{lack}: {text_of(reason).partition(';')[0]}" if reason else "", characters=characters)


def mark_zero(axes: Axes, *, x: bool = False, y: bool = True, **look: Any) -> None:
    """Draw thin lines at zero: along the x axis (``y`` = 0) and along the y axis (``x`` = 0)."""
    look = {"color": theme.MUTED, "lw": 0.4, "zorder": 1, **look}
    if y:
        axes.axhline(0.0, **look)
    if x:
        axes.axvline(0.0, **look)


def shade_stretches(axes: Axes, starts: Iterable[float], stops: Iterable[float]) -> None:
    """Shade every other stretch of time."""
    for start, stop in list(zip(starts, stops, strict=False))[::2]:
        axes.axvspan(start, stop, facecolor=theme.SHADE, linewidth=0, zorder=0)


def add_legend(figure: Figure, order: Sequence[str] = ()) -> None:
    """Write one legend above all panels with every label of them once, those of ``order`` first."""
    found: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    rest = sorted((label for label in found if label not in order), key=lambda label: isinstance(found[label], Patch))
    labels = [*(label for label in order if label in found), *rest]
    if not labels:
        return
    longest = max(min(len(label), LONGEST_FORMULA) if "$" in label else len(label) for label in labels)
    columns = max(1, int(72.0 * figure.get_figwidth() / (HANDLE_PT + LETTER_PT * longest)))
    legend = figure.legend([found[label] for label in labels], labels, loc="outside upper center", ncols=columns)
    for text in legend.get_texts():
        text.set_parse_math(True)  # no name from a log stands there


def band(axes: Axes, x: Float, low: Float, high: Float, colour: str, label: str, **look: Any) -> None:
    """Fill the space between two curves; arrays of shape (n,)."""
    look = {"color": colour, "alpha": 0.2, "lw": 0, "label": label, **look}
    axes.fill_between(x, low, high, **look)


def limits(shown: Float, others: Float, *, near: float, smallest: float) -> tuple[float, float] | None:
    """Return the ends of an axis that hold all numbers shown; others extend it by at most ``near`` times their range.

    That range is at least ``smallest``. NaN is no number; None without any.
    """
    shown, others = (values[np.isfinite(values)] for values in (shown, others))
    if not len(shown):
        return None
    low, high = float(shown.min()), float(shown.max())
    reach = near * max(high - low, smallest)
    inside = np.clip(np.append(others, (low, high)), low - reach, high + reach)
    bottom, top = min(low, float(inside.min())), max(high, float(inside.max()))
    margin = 0.05 * max(top - bottom, smallest)
    return bottom - margin, top + margin


CUTOFF_HZ = 10.0  # corner of the low-pass filter of the drawn curves, as in the paper
ORDER = 2
SHORTEST = 20  # samples below which a filter makes no sense
MOST_POINTS = 20_000  # points of one curve that a reader can still tell apart, and a file can still hold


def cutoff_hz(t: Float) -> float:
    """Return the corner in force: CUTOFF_HZ, or less where the log is too slow for it. [Hz]"""
    return min(CUTOFF_HZ, 0.2 / median_step(t))


def smooth(t: Float, signal: Float) -> Float:
    """Return the signal after a zero-phase Butterworth low-pass filter, both of shape (n,)."""
    from scipy.signal import butter, sosfiltfilt

    if len(t) < SHORTEST:
        return signal
    sections = butter(ORDER, cutoff_hz(t), fs=1.0 / median_step(t), output="sos")
    return np.asarray(sosfiltfilt(sections, signal, padlen=min(len(t) - 1, 3 * SHORTEST)), dtype=np.float64)


def every_nth(samples: int, most: int = MOST_POINTS) -> slice:
    """Return the stride that leaves at most ``most`` of n samples."""
    return slice(None, None, max(1, -(-samples // most)))


def thin_extremes(t: Float, signal: Float, most: int = MOST_POINTS) -> tuple[Float, Float]:
    """Return at most ``most`` samples with the smallest and the largest of every stretch, in order; shape (n,) each."""
    width = -(-2 * len(t) // most)
    if width <= 1 or len(t) <= most:
        return t, signal
    whole = len(t) // width * width
    stretches = signal[:whole].reshape(-1, width)
    first = np.arange(0, whole, width)
    places = np.concatenate([first + stretches.argmin(axis=1), first + stretches.argmax(axis=1), [len(t) - 1]])
    kept = np.unique(places)
    return t[kept], signal[kept]


def break_at_gaps(t: Float, signal: Float, longest_s: float) -> Float:
    """Return the signal with NaN after every step of time longer than ``longest_s``: a line must not bridge a gap."""
    broken = signal.copy()
    broken[:-1][np.diff(t) > longest_s] = np.nan
    return broken


GAP_PERIODS = 20  # sampling periods without a sample after which no line is drawn


def draw_curve(axes: Axes, t: Float, signal: Float, points: int, **look: Any) -> None:
    """Draw a signal over time, thinned to its extremes; no line bridges a gap."""
    stamps, kept = thin_extremes(t, signal, points)
    if len(t) > 1:
        longest_s = GAP_PERIODS * median_step(t) + 2 * (t[-1] - t[0]) / len(stamps)
        kept = break_at_gaps(stamps, kept, longest_s)
    axes.plot(stamps, kept, **look)


def draw_raw_and_filtered(axes: Axes, t: Float, signal: Float, points: int, **filtered: Any) -> None:
    """Draw a signal over time as measured and filtered."""
    draw_curve(axes, t, signal, points, color=theme.RAW, lw=0.5, label="raw", rasterized=True)
    look: Look = {"color": theme.FILTERED, "lw": 0.7, "label": f"filtered, {cutoff_hz(t):.3g} Hz", **filtered}
    draw_curve(axes, t, smooth(t, signal), points, **look)


def draw_dots(axes: Axes, x: Float, y: Float, colour: str, label: str, **look: Any) -> None:
    """Draw a cloud of dots as an image; in the legend they are large enough to be seen."""
    axes.plot(x, y, ".", color=colour, ms=1.2, mew=0, rasterized=True, **look)
    axes.plot([], [], ".", color=colour, ms=5, mew=0, label=label)


ARROWS_AT, ARROW_LENGTH = 0.6, 0.06  # share of a stroke's peak speed at which an arrow stands; share of both ranges


def draw_arrows(axes: Axes, dq: Float, torque: Float) -> None:
    """Add arrows in the direction of time to a smooth curve, shape (n,): two to the fastest stroke each way."""
    look: Look = {"arrowstyle": "-|>", "color": theme.FILTERED, "lw": 0.9, "mutation_scale": 9}
    look |= {"shrinkA": 0, "shrinkB": 0}
    across, up = (float(np.nanmax(one) - np.nanmin(one)) or 1.0 for one in (dq, torque))
    for fastest in (int(np.nanargmax(dq)), int(np.nanargmin(dq))):
        slow = ~(np.sign(dq[fastest]) * dq >= ARROWS_AT * abs(dq[fastest]))
        for tail in (fastest - int(np.argmax(slow[fastest::-1])), fastest + int(np.argmax(slow[fastest:]))):
            distance = np.hypot((dq - dq[tail]) / across, (torque - torque[tail]) / up)
            head = tail + int(np.argmax(distance[tail:] > ARROW_LENGTH))
            axes.annotate("", (dq[head], torque[head]), (dq[tail], torque[tail]), arrowprops=look, zorder=5)


def label_in_unit(figure: Drawn, unit: str) -> Drawn:
    """Write the unit of the torque on the axes of a figure, or on axes."""
    if unit != NEWTON_METRES:
        for text in figure.findobj(Text):
            text.set_text(in_unit(text.get_text(), unit))
    return figure
