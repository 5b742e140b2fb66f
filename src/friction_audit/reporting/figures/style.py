"""Names that a log gives, as a figure can write them."""

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.reporting.words import joint_label

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


def joint_title(joint: int, name: str) -> str:
    """Return what a panel of a figure calls a joint."""
    return f"joint {joint_label(joint, name)}"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointSeries:
    """One joint's signals, cycles and friction.

    Attributes:
        number: Joint number for people.
        name: Name in the log.
        t: Time, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        torque: Interaction torque, shape (n,). [N m]
        compensation: Torque of a logged compensator, shape (n,), or None. [N m]
        cycles: Its cycles; start and stop are indices into the arrays above.
        friction: Its coefficients.
    """

    number: int
    name: str
    t: Float
    dq: Float
    torque: Float
    compensation: Float | None
    cycles: EnergyCycles
    friction: JointFriction

    @property
    def title(self) -> str:
        """What a panel is called: the joint's number, and its name where that says more."""
        return joint_title(self.number, self.name)

    @property
    def not_determined(self) -> str:
        """The words for a panel without an estimate, without the advice behind the semicolon; empty if there is one."""
        return f"not determined: {self.friction.reason.partition(';')[0]}" if self.friction.reason else ""

    @property
    def driving_torque(self) -> Float:
        """What acts against friction and inertia: F_m + u, shape (n,). [N m]"""
        return self.torque if self.compensation is None else self.torque + self.compensation

    def first_cycles(self, count: int) -> "JointSeries":
        """Return the stretch of the log that the first cycles fill; all of it without any cycle."""
        if not len(self.cycles.joint):
            return self
        kept = self.cycles.rows(np.arange(len(self.cycles.joint)) < count)
        begin, end = int(kept.start[0]), int(kept.stop[-1]) + 1
        return replace(
            self,
            t=self.t[begin:end],
            dq=self.dq[begin:end],
            torque=self.torque[begin:end],
            compensation=None if self.compensation is None else self.compensation[begin:end],
            cycles=replace(kept, start=kept.start - begin, stop=kept.stop - begin),
        )


def joint_series(estimate: Estimate, joint: int) -> JointSeries:
    """Return the series of a joint, given by its number for people.

    Raises:
        UsageError: If the result does not hold that joint.
    """
    numbers = estimate.interaction.joint_numbers
    if joint not in numbers:
        held = ", ".join(map(str, numbers))
        raise UsageError(f"joint {joint}: not in this result, which holds {held}; choose one of them")
    column = numbers.index(joint)
    compensation = estimate.interaction.compensation
    return JointSeries(
        number=joint,
        name=estimate.interaction.joint_names[column],
        t=estimate.interaction.t,
        dq=estimate.interaction.dq[:, column],
        torque=estimate.interaction.torque[:, column],
        compensation=None if compensation is None else compensation[:, column],
        cycles=estimate.cycles.of_joint(column),
        friction=next(found for found in estimate.friction.joints if found.joint == joint),
    )


def all_series(estimate: Estimate) -> tuple[JointSeries, ...]:
    """Return the series of every joint of a result, in order."""
    return tuple(joint_series(estimate, joint) for joint in estimate.interaction.joint_numbers)


COLUMN_IN = 3.5
"""Width of a figure of one joint: a column of a two-column paper. [in]"""
SHEET_IN = 7.0
"""Width of a sheet of all joints: the page. [in]"""

# Okabe and Ito's colours, distinguishable with any colour vision.
RAW = "#9ecae8"
FILTERED = "#004c80"
FITTED = "#d55e00"
DISSIPATED = "#e69f00"
BORDER = "#000000"
SHADE = "#e9e9e9"
ZOOMED = "#d9ecd9"
REJECTED = "#cc79a7"
MUTED = "#555555"

RC: dict[str, Any] = {
    "font.size": 7.5,
    "axes.labelsize": 7.5,
    "axes.titlesize": 7.5,
    "axes.titlelocation": "left",
    "axes.titlepad": 3.0,
    "axes.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "lines.linewidth": 0.8,
    "hatch.linewidth": 0.4,
    "figure.constrained_layout.h_pad": 0.02,
    "figure.constrained_layout.w_pad": 0.02,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "svg.hashsalt": "friction-audit",
}


@contextmanager
def figure_style(*, mathematics: bool = False) -> Iterator[None]:
    """Use the figures' style inside the block; a letter that its font lacks is a box, or the reader's own in a page.

    Args:
        mathematics: Whether words between dollar signs are formulas, where no word comes from a log.
    """
    import warnings

    from matplotlib import rc_context, rcParamsDefault

    # The user's own matplotlibrc must not change what a result looks like.
    defaults: dict[Any, Any] = rcParamsDefault  # told the type of every name, mypy looks at this line for seconds
    settings = {name: value for name, value in defaults.items() if name != "backend"} | RC
    settings["text.parse_math"] = mathematics
    with rc_context(settings), warnings.catch_warnings():
        # Names of joints may be in any script; there is nothing that the user could do about the font.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


MOST_SHADED = 80
"""Cycles in one panel above which stripes would only be grey."""
LONGEST_LABEL = 24
"""Characters of a label up to which two stand side by side in a column of a paper."""
TICKS_ON_SHEET = 4
TICKS_IN_COLUMN = 6


def new_figure(width_in: float, height_in: float) -> "Figure":
    """Return an empty figure that no screen and no global state knows of."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


def new_pairs(joints: int, *, sheet: bool) -> "tuple[Figure, NDArray[np.object_]]":
    """Return a figure over time and its two panels per joint: a row of a sheet, or above each other in a column."""
    if sheet:
        figure = new_figure(SHEET_IN, 0.6 + 1.15 * joints)
        return figure, figure.subplots(joints, 2, squeeze=False, sharex=True)
    figure = new_figure(COLUMN_IN, 3.2)
    return figure, figure.subplots(2, 1, squeeze=False, sharex=True).T


def label_panel(axes: "Axes", title: str, *, across: int | None = None) -> None:
    """Write the panel's title above the upper left corner and keep the ticks few, ``across`` along the x axis."""
    from matplotlib.ticker import MaxNLocator

    axes.set_title(title, loc="left")
    ticks = TICKS_IN_COLUMN if is_narrow(axes.get_figure(root=True)) else TICKS_ON_SHEET
    for axis, most in ((axes.xaxis, across or ticks), (axes.yaxis, ticks)):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))


def say_in_panel(axes: "Axes", sentence: str, *, characters: int) -> None:
    """Write a sentence into a panel, wrapped, on a ground that keeps it readable."""
    if not sentence:
        return
    axes.text(
        0.5,
        0.5,
        fill(sentence, characters),
        transform=axes.transAxes,
        ha="center",
        va="center",
        fontsize=6.5,
        color=BORDER,
        bbox={"facecolor": "white", "edgecolor": MUTED, "linewidth": 0.4, "pad": 2.5, "alpha": 0.92},
        zorder=10,
    )


def is_crowded(series: JointSeries) -> bool:
    """Return True where a joint has too many cycles to tell them apart in one panel."""
    return len(series.cycles.joint) > MOST_SHADED


def shade_cycles(axes: "Axes", series: JointSeries) -> None:
    """Shade every other cycle of a joint and hatch the ones left out of the estimates."""
    cycles = series.cycles
    if is_crowded(series):
        return
    for row, (start, stop, reason) in enumerate(zip(cycles.start_s, cycles.stop_s, cycles.reason, strict=True)):
        if reason == 0 and row % 2 == 0:
            axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0)
        if reason != 0:
            axes.axvspan(start, stop, facecolor="none", edgecolor=REJECTED, hatch="/////", linewidth=0, zorder=0)


def cycle_handles(all_series: Sequence[JointSeries]) -> "list[Artist]":
    """Return the legend's entries for what shade_cycles drew on the panels of these joints."""
    from matplotlib.patches import Patch

    shown = [series for series in all_series if len(series.cycles.joint) and not is_crowded(series)]
    handles: list[Artist] = [Patch(facecolor=SHADE, label="cycle (every other)")] if shown else []
    if any((series.cycles.reason != 0).any() for series in shown):
        handles.append(Patch(facecolor="none", edgecolor=REJECTED, hatch="/////", linewidth=0, label="cycle left out"))
    if any(map(is_crowded, all_series)):
        handles.append(Patch(facecolor="none", linewidth=0, label=f"more than {MOST_SHADED} cycles are not shaded"))
    return handles


def add_legend(figure: "Figure", handles: "Sequence[Artist]", *, formula: str | None = None) -> None:
    """Write one legend above all panels, as wide as the figure allows; the label that is a formula as one."""
    if not handles:
        return
    longest = max(len(str(handle.get_label())) for handle in handles if handle.get_label() != formula)
    columns = (2 if longest <= LONGEST_LABEL else 1) if is_narrow(figure) else 6
    legend = figure.legend(handles=list(handles), loc="outside upper center", ncols=columns)
    for text in legend.get_texts():
        text.set_parse_math(text.get_text() == formula)


def is_narrow(figure: "Figure | None") -> bool:
    """Return True for a figure of one column of a paper."""
    return figure is not None and figure.get_figwidth() <= COLUMN_IN


FORMATS = ("png", "svg", "pdf")
UNDATED = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}, "pdf": {"CreationDate": None}}
"""Metadata that would change from run to run or from one matplotlib to the next, left out."""
BACKENDS = {"png": "agg", "svg": "svg", "pdf": "pdf"}


def load_matplotlib(formats: Iterable[str]) -> None:
    """Load what it takes to draw figures in these formats, before the process is copied."""
    for kind in formats:
        import_module(f"matplotlib.backends.backend_{BACKENDS[kind]}")


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure in the format that the suffix names, one of FORMATS."""
    path.write_bytes(figure_bytes(figure, path.suffix[1:]))


def figure_bytes(figure: "Figure", kind: str) -> bytes:
    """Return the content of a figure's file.

    Args:
        figure: The figure.
        kind: One of FORMATS.
    """
    content = io.BytesIO()
    with figure_style(mathematics=True):  # of axes that draw their numbers only now
        figure.savefig(content, format=kind, metadata=UNDATED[kind])
    return content.getvalue()


CUTOFF_HZ = 10.0
"""Corner of the low-pass filter of the drawn curves. [Hz]"""
ORDER = 2
SHORTEST = 20
"""Samples below which a filter makes no sense."""


def cutoff_hz(t: Float) -> float:
    """Return the corner in force: CUTOFF_HZ, or less where the log is too slow for it. [Hz]"""
    return min(CUTOFF_HZ, 0.2 * median_rate_hz(t))


def median_rate_hz(t: Float) -> float:
    """Return the sampling rate of stamps, shape (n,). [Hz]"""
    return 1.0 / float(np.median(np.diff(t)))


def smooth(t: Float, signal: Float) -> Float:
    """Return the signal after a zero-phase Butterworth low-pass filter, both of shape (n,)."""
    from scipy.signal import butter, sosfiltfilt

    if len(t) < SHORTEST:
        return signal
    sections = butter(ORDER, cutoff_hz(t), fs=median_rate_hz(t), output="sos")
    return np.asarray(sosfiltfilt(sections, signal, padlen=min(len(t) - 1, 3 * SHORTEST)), dtype=np.float64)


MOST_POINTS = 20_000
"""Points of one curve that a reader could still tell apart, and a file can still hold."""


def every_nth(samples: int, most: int = MOST_POINTS) -> slice:
    """Return the stride that leaves at most ``most`` of n samples."""
    return slice(None, None, max(1, -(-samples // most)))


def thin_extremes(t: Float, signal: Float, most: int = MOST_POINTS) -> tuple[Float, Float]:
    """Return at most ``most`` samples that hold the smallest and the largest of every stretch, in order of time.

    Args:
        t: Time, shape (n,). [s]
        signal: Shape (n,).
        most: Number of points wanted.
    """
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
    """Return the signal with NaN after every step of time longer than ``longest_s``: no line is drawn over a hole."""
    broken = signal.copy()
    broken[:-1][np.diff(t) > longest_s] = np.nan
    return broken
