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
        figure.savefig(content, format=kind, metadata=UNDATED[kind])
    return content.getvalue()
