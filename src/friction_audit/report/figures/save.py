"""Figure -> file, the same bytes for the same result."""

import io
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.report.figures.style import figure_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
        if kind == "png":
            _paint(figure, content)
        else:
            figure.savefig(content, format=kind, metadata=UNDATED[kind])
    return content.getvalue()


def _paint(figure: "Figure", content: io.BytesIO) -> None:
    """Write what ``savefig`` would, which draws a figure twice: first to lay it out, though drawing does that too."""
    from matplotlib import rcParams
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    resolution = figure.dpi
    figure.set_dpi(rcParams["savefig.dpi"])
    FigureCanvasAgg(figure).print_png(content, metadata=UNDATED["png"])  # type: ignore[no-untyped-call]
    figure.set_dpi(resolution)
