"""Figure -> SVG that stands inside a page."""

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from friction_audit.errors import printable
from friction_audit.reporting.figures.style import figure_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SVG, XLINK = "http://www.w3.org/2000/svg", "{http://www.w3.org/1999/xlink}href"
REFERENCE = re.compile(r"url\(#([^)]+)\)")
# A coordinate finer than a hundredth of a point is not visible; without it a page is a third smaller.
FINE = re.compile(r"\d+\.\d{3,}")
# Words as text: small, searchable and read aloud; clouds of dots, which are images, as fine as a screen shows them.
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
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
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
    root.attrib |= {"role": "img", "aria-labelledby": f"{prefix}-title", "focusable": "false"}
    ET.register_namespace("", SVG)
    return Picture(svg=ET.tostring(root, encoding="unicode"), width=width, description=description)


def _rename(root: ET.Element, prefix: str) -> None:
    """Begin the ids that something refers to with the prefix, drop the others, and round coordinates."""
    used = {element.get(XLINK, "").removeprefix("#") for element in root.iter()}
    used |= {name for element in root.iter() for value in element.attrib.values() for name in REFERENCE.findall(value)}
    for element in root.iter():
        name = element.attrib.pop("id", None)
        if name in used:
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
