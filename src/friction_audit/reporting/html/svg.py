"""A drawing, whatever it is drawn for."""

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from friction_audit.errors import printable
from friction_audit.reporting.figures.style import figure_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A drawing for a page.

    Attributes:
        width: Width at which its text is as large as it was drawn. [pt]
        description: What it shows, for those who do not see it.
    """

    width: float
    description: str

    @property
    def size(self) -> int:
        """Room that it takes in a file. [bytes]"""
        raise NotImplementedError


SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
COLOUR = re.compile(r"#[0-9a-f]{6}\b")
REFERENCE = re.compile(r"url\(#([^)]+)\)")
FONT = re.compile(r"font: ((?:[\w.]+ )*?[\d.]+px) [^;]*|font-family: [^;]*")
LONG = re.compile(r"\d+\.\d{3,}")
"""A coordinate finer than a hundredth of a point, which nobody sees."""
IN_PAGE: dict[Any, Any] = {"svg.fonttype": "none", "savefig.dpi": 120}
"""Words as text; clouds of dots, which are images, as fine as a screen shows them."""
BLACK = "#000000"
"""Colour of what names none."""
FILLED = frozenset(f"{{{SVG}}}{name}" for name in ("text", "path", "use"))
"""Elements that are filled unless they say otherwise."""


@dataclass(frozen=True, kw_only=True, slots=True)
class InlinePicture(Picture):
    """A drawing to stand inside a page of HTML.

    Attributes:
        svg: Its markup; the words in it are escaped.
        colours: The colours in it, ``#rrggbb``, each drawn as the page's ``--c-rrggbb``.
    """

    svg: str
    colours: frozenset[str]

    @property
    def size(self) -> int:
        """Letters of its markup."""
        return len(self.svg)


def draw_inline(figure: "Figure", *, prefix: str, description: str) -> InlinePicture:
    """Return a figure as SVG to stand inside a page.

    Args:
        figure: The figure.
        prefix: Starts every id in it, so that figures of one page do not share any.
        description: What it shows, for those who do not see it.
    """
    root = ET.fromstring(printable(_draw(figure)))  # noqa: S314 - drawn here, not read from anywhere
    _strip(root)
    _rename(root, prefix)
    colours = _recolour(root)
    _, _, width, _ = map(float, root.attrib["viewBox"].split())
    _describe(root, prefix, description)
    ET.register_namespace("", SVG)
    text = ET.tostring(root, encoding="unicode")
    return InlinePicture(svg=text, width=width, description=description, colours=colours)


def _draw(figure: "Figure") -> str:
    """Return a figure as SVG with its words as text: small, searchable, and read aloud."""
    from matplotlib import rc_context

    text = io.StringIO()
    with figure_style(), rc_context(IN_PAGE):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    return text.getvalue()


def _strip(root: ET.Element) -> None:
    """Leave out what a page has no use for."""
    for element in root.iter():
        for child in list(element):
            if child.tag.endswith(("metadata", "}style")):
                element.remove(child)
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)


def _rename(root: ET.Element, prefix: str) -> None:
    """Keep only ids that something refers to, and begin them with the prefix."""
    used = {name for element in root.iter() for name in _references(element)}
    for element in root.iter():
        name = element.attrib.pop("id", None)
        if name in used:
            element.set("id", f"{prefix}-{name}")
        link = element.attrib.pop(f"{{{XLINK}}}href", None)
        if link is not None:  # within the drawing, or an image that is the link itself
            element.set("href", f"#{prefix}-{link[1:]}" if link.startswith("#") else link)
        for key in ("clip-path", "style"):
            if key in element.attrib:
                element.set(key, REFERENCE.sub(rf"url(#{prefix}-\1)", element.attrib[key]))


def _references(element: ET.Element) -> list[str]:
    """Return the ids that an element refers to."""
    link = element.attrib.get(f"{{{XLINK}}}href", "")
    places = [place for key in ("clip-path", "style") for place in REFERENCE.findall(element.attrib.get(key, ""))]
    return [*places, link.removeprefix("#")]


def _recolour(root: ET.Element) -> frozenset[str]:
    """Name each colour as the page's, the font as the page's; return the colours."""
    found: set[str] = set()
    defined = {element for defs in root.iter(f"{{{SVG}}}defs") for element in defs.iter()}
    for element in root.iter():
        for key in ("d", "x", "y", "transform"):
            if key in element.attrib:
                element.set(key, LONG.sub(_rounded, element.attrib[key]))
        style = element.attrib.get("style")
        # What is black is not said; what is defined takes the colour of where it is used.
        if element.tag in FILLED and element not in defined and "fill:" not in (style or ""):
            style = f"{style or ''}; fill: {BLACK}"
        if style is None:
            continue
        found.update(COLOUR.findall(style))
        style = COLOUR.sub(lambda match: f"var(--c-{match[0][1:]})", style)
        element.set("style", FONT.sub(_font, style))
    return frozenset(found)


def _font(match: re.Match[str]) -> str:
    return f"font: {match[1]} var(--font)" if match[1] else "font-family: var(--font)"


def _rounded(match: re.Match[str]) -> str:
    return f"{float(match[0]):.2f}".rstrip("0").rstrip(".")


def _describe(root: ET.Element, prefix: str, description: str) -> None:
    """Give the drawing a name that is read aloud."""
    title = ET.Element(f"{{{SVG}}}title", {"id": f"{prefix}-title"})
    title.text = printable(description)
    root.insert(0, title)
    root.set("role", "img")
    root.set("aria-labelledby", f"{prefix}-title")
    root.set("focusable", "false")
