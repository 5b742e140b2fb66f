"""Figure -> file, the same bytes for the same result."""

from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.report.figures.style import figure_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
UNDATED = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}, "pdf": {"CreationDate": None}}
"""Metadata that would change from run to run or from one matplotlib to the next, left out."""


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure in the format that the suffix names, one of FORMATS."""
    kind = path.suffix[1:]
    with figure_style():
        figure.savefig(path, format=kind, metadata=UNDATED[kind])
