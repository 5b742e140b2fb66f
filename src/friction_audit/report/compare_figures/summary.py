"""All methods at a glance: energy slope and torque, with their intervals."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from friction_audit.report.compare_figures.look import LOOKS, LOST
from friction_audit.report.figures.layout import add_legend, label_panel, new_figure
from friction_audit.report.figures.style import COLUMN_IN, MUTED, figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = Mapping[str, Any]

PANELS = (
    ("energy_slope_w", 1000.0, "(a) slope [mW]"),
    ("rms_torque_nm", 1.0, "(b) rms torque [N m]"),
)
LOST_AT = 0.97
"""Where a panel says how often a loop was lost, of its width."""

SHIFTS = {"paper": -0.14, "best": 0.14}
"""Where a role's marker stands, in rows."""


def draw_summary(rows: Iterable[Row]) -> "Figure":
    """Draw the paper's kind of tuning and the best one of every method, with 95 % intervals.

    Args:
        rows: Entries of ``methods`` in the document.
    """
    told = [row for row in rows if row["role"] in SHIFTS]
    labels = list(dict.fromkeys(row["label"] for row in told))
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 0.9 + 0.27 * len(labels))
        panels = figure.subplots(1, len(PANELS), sharey=True)
        for axes, (name, factor, title) in zip(panels, PANELS, strict=True):
            _draw_panel(axes, told, labels, name, factor)
            label_panel(axes, title, across=4)
            _tell_losses(axes, told, labels)
            axes.set_ylim(len(labels) - 0.5, -0.5)
            axes.set_yticks(range(len(labels)), labels)
            axes.tick_params(axis="y", length=0)
        shapes = (("o", "full", "the paper's kind of tuning"), ("D", "none", "best stable tuning"))
        handles = [
            panels[0].plot([], [], shape, color=MUTED, fillstyle=fill, ms=3.5, mew=0.8, label=label)[0]
            for shape, fill, label in shapes
        ]
        add_legend(figure, handles)
        return figure


def _tell_losses(axes: "Axes", rows: Sequence[Row], labels: Sequence[str]) -> None:
    """Write at the right how many loops were lost: those are not in the means."""
    for row in rows:
        if row["lost_s"]:
            axes.text(
                LOST_AT,
                labels.index(row["label"]) + SHIFTS[row["role"]],
                f"{1 - row['stable_share']:.0%} lost",
                transform=axes.get_yaxis_transform(),
                ha="right",
                va="center",
                fontsize=5.5,
                color=LOST,
            )


def _draw_panel(axes: "Axes", rows: Sequence[Row], labels: Sequence[str], name: str, factor: float) -> None:
    axes.axvline(0.0, color=MUTED, lw=0.4, zorder=1)
    alone = {row["label"] for row in rows if sum(other["label"] == row["label"] for other in rows) == 1}
    for row in rows:
        told, best = row[name], row["role"] == "best"
        place = labels.index(row["label"]) + (0.0 if row["label"] in alone else SHIFTS[row["role"]])
        value = factor * told["value"]
        low, high = (factor * bound for bound in told["ci95"])
        axes.errorbar(
            value,
            place,
            xerr=[[value - low], [high - value]],
            fmt="D" if best else "o",
            fillstyle="none" if best else "full",
            color=LOOKS[row["method"]].colour,
            ms=3.5,
            mew=0.8,
            elinewidth=0.8,
            capsize=1.5,
            zorder=3,
        )
