"""Figure -> SVG that stands inside a page."""

import io
import json
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np

from friction_audit.errors import printable
from friction_audit.reporting.figures.style import figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SVG, XLINK = "http://www.w3.org/2000/svg", "{http://www.w3.org/1999/xlink}href"
REFERENCE = re.compile(r"url\(#([^)]+)\)")
# A coordinate finer than a hundredth of a point is not visible; without it a page is a third smaller.
FINE = re.compile(r"\d+\.\d{3,}")
# Words as text: small, searchable and read aloud; clouds of dots, which are images, as fine as a screen shows them.
CURVE = "curve of "  # what the id of a curve begins with while it is drawn
CURVED = 33  # values that stand for an axis that is not linear
IN_PAGE: dict[Any, Any] = {"svg.fonttype": "none", "savefig.dpi": 120}


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A drawing for a page.

    Attributes:
        svg: Its markup; the words in it are escaped.
        width: Width at which its text is as large as it was drawn. [pt]
        description: What it shows, for those who do not see it.
    """

    svg: str
    width: float
    description: str


def draw_inline(figure: "Figure", *, prefix: str, description: str) -> Picture:
    """Return a figure as SVG to stand inside a page.

    Args:
        figure: The figure.
        prefix: Starts every id in it, so that figures of one page do not share any.
        description: What it shows, for those who do not see it.
    """
    from matplotlib import rc_context

    stream = io.StringIO()
    with figure_style(), rc_context(IN_PAGE):
        for line in (line for axes in figure.axes for line in axes.lines):
            name = str(line.get_label())
            line.set_gid(None if line.get_rasterized() or name.startswith("_") else f"{CURVE}{name}")
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
        panels = [_panel(axes) for axes in figure.axes if axes.axison]
    root = ET.fromstring(printable(stream.getvalue()))  # noqa: S314 - drawn here, not read from anywhere
    for parent in root.iter():
        for child in [one for one in parent if one.tag.endswith(("metadata", "}style"))]:
            parent.remove(child)
    _rename(root, prefix)
    title = ET.Element(f"{{{SVG}}}title", {"id": f"{prefix}-title"})
    title.text = printable(description)
    root.insert(0, title)
    width = float(root.attrib["viewBox"].split()[2])
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    root.attrib |= {
        "data-panels": json.dumps(panels),
        "role": "img",
        "aria-labelledby": f"{prefix}-title",
        "focusable": "false",
    }
    ET.register_namespace("", SVG)
    return Picture(svg=ET.tostring(root, encoding="unicode"), width=width, description=description)


def _panel(axes: "Axes") -> list[Any]:
    """Return where a panel is [pt], the values along its axes and their names, for the value under a pointer."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    box, (wide, high) = axes.get_position(), 72.0 * figure.get_size_inches()
    place = [box.x0 * wide, (1.0 - box.y1) * high, box.width * wide, box.height * high]
    shares = np.linspace(0.0, 1.0, 2 if (axes.get_xscale(), axes.get_yscale()) == ("linear", "linear") else CURVED)
    values = axes.transData.inverted().transform(axes.transAxes.transform(np.column_stack([shares, shares])))
    names = (axes.get_xlabel() or figure.get_supxlabel(), axes.get_ylabel() or figure.get_supylabel())
    along = [[float(f"{value:.5g}") for value in column] for column in values.T]
    return [*(round(length, 1) for length in place), *along, *(name.partition("\n")[0] for name in names)]


def _rename(root: ET.Element, prefix: str) -> None:
    """Begin the ids that something refers to with the prefix, drop the others, and round coordinates."""
    used = {element.get(XLINK, "").removeprefix("#") for element in root.iter()}
    used |= {name for element in root.iter() for value in element.attrib.values() for name in REFERENCE.findall(value)}
    for element in root.iter():
        name = element.attrib.pop("id", "")
        if name.startswith(CURVE):
            element.set("data-curve", printable(name.removeprefix(CURVE)))
        if name and name in used:
            element.set("id", f"{prefix}-{name}")
        link = element.attrib.pop(XLINK, None)
        if link is not None:  # within the drawing, or an image that is the link itself
            element.set("href", f"#{prefix}-{link[1:]}" if link.startswith("#") else link)
        for key in ("d", "x", "y", "transform", "clip-path", "style"):
            if key in element.attrib:
                text = REFERENCE.sub(rf"url(#{prefix}-\1)", element.attrib[key])
                element.set(key, text if key == "style" else FINE.sub(_rounded, text))


def _rounded(match: re.Match[str]) -> str:
    return f"{float(match[0]):.2f}".rstrip("0").rstrip(".")
