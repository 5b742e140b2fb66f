"""Figures that are made and not painted: painting takes longest of all, and what is painted is tested with the figures.

What a command draws is put together as ever, and its files are there; with ``--thorough`` they are painted too.
"""

import io
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS_PER_INCH = 72.0
PDF = b"%PDF-1.4\n"
PNG = b"\x89PNG\r\n\x1a\n"
"""What a file of this format begins with."""


def sketch(figure: "Figure", target: io.StringIO | io.BytesIO, *, format: str, **_: Any) -> None:  # noqa: A002
    """Write an empty sheet of the figure's size in place of ``Figure.savefig``."""
    width, height = (POINTS_PER_INCH * float(inches) for inches in figure.get_size_inches())
    if format == "pdf":
        assert isinstance(target, io.BytesIO)
        target.write(PDF)
        return
    svg = f'<?xml version="1.0"?><svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"/>'
    if isinstance(target, io.StringIO):
        target.write(svg)
    else:
        target.write(svg.encode() if format == "svg" else PNG)
