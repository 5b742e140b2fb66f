"""What a page is made of; every word in it is text and is escaped when the page is written."""

import base64
import colorsys
import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Literal

from friction_audit import __version__
from friction_audit.errors import printable
from friction_audit.reporting.html.svg import InlinePicture, Picture

if TYPE_CHECKING:
    from jinja2 import Environment


Tone = Literal["", "alert", "fine", "unsure", "off"]
"""How a verdict looks, beside its words."""


LONG = 30
"""Rows of a table above which it gets a window of its own."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Cell:
    """A cell of a table.

    Attributes:
        text: What it says.
        key: What it is sorted by: a number, or the text if None; NaN comes last.
        tone: For a verdict.
        code: Whether it is the name of a file or the like, which may break anywhere.
        words: Whether it is a phrase, for which a column must leave room, or it is a tower of single words.
    """

    text: str
    key: float | None = None
    tone: Tone = ""
    code: bool = False
    words: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Table:
    """A table that can be sorted.

    Attributes:
        caption: What it shows.
        titles: Heads of the columns.
        rows: Cells, as many in a row as there are titles; the first heads the row.
        numbers: Which columns hold numbers, from 0; they are set to the right.
        folded: Whether it is shown only when asked for.
    """

    caption: str
    titles: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    numbers: frozenset[int] = frozenset()
    folded: bool = False

    @property
    def long(self) -> bool:
        """Whether it scrolls in a window of its own."""
        return len(self.rows) > LONG


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """A figure that can be enlarged.

    Attributes:
        picture: The drawing.
        title: What it shows, in a line.
        caption: How to read it.
    """

    picture: Picture
    title: str
    caption: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Verdict:
    """A verdict in words and a colour.

    Attributes:
        name: Of what.
        word: The verdict.
        tone: How it looks.
        sentence: What is to be said of it.
    """

    name: str
    word: str
    tone: Tone
    sentence: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Verdicts:
    """A list of verdicts."""

    verdicts: Sequence[Verdict]


@dataclass(frozen=True, kw_only=True, slots=True)
class Text:
    """Sentences, a paragraph each, or the points of a list.

    Attributes:
        lines: The sentences.
        listed: Whether they are points of a list.
        tone: ``"alert"`` for what must not be missed.
    """

    lines: Sequence[str]
    listed: bool = False
    tone: Tone = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Command:
    """A command to be typed, which can be copied."""

    line: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Terms:
    """Words and what they mean, or names and values."""

    pairs: Sequence[tuple[str, str]]


Part = Table | Figure | Verdicts | Text | Command | Terms


@dataclass(frozen=True, kw_only=True, slots=True)
class Section:
    """A section with a heading, and sections in it.

    Attributes:
        anchor: Unique name of ASCII letters, digits and hyphens, for the table of contents.
        title: The heading.
        parts: What is in it, in order.
        sections: Sections in it.
    """

    anchor: str
    title: str
    parts: Sequence[Part] = ()
    sections: Sequence["Section"] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class Page:
    """A page.

    Attributes:
        title: Of the page.
        lead: What it says, in a sentence or two.
        facts: What it is about: names and values.
        sections: What is in it.
    """

    title: str
    lead: str
    facts: Sequence[tuple[str, str]] = ()
    sections: Sequence[Section] = field(default=())


METHOD = (
    "H. T. Dinc, J.-K. Lee, J.-H. Ryu, Model-Free Energy-Based Friction Compensation for Industrial Collaborative "
    "Robots as Haptic Displays, IEEE/ASME Transactions on Mechatronics, 2024, doi 10.1109/TMECH.2024.3410330."
)
PROGRAM = f"friction-audit {__version__}. The program is not by the authors of the method."


def citation_section() -> Section:
    """Return how to cite."""
    lead = "Friction is estimated from the energy balance between two moments of rest. When you publish, cite"
    parts = (Text(lines=(lead,)), Text(lines=(METHOD, PROGRAM), listed=True))
    return Section(anchor="cite", title="How to cite", parts=parts)


DARK_GROUND = "#14181d"
READABLE = 4.5
"""Contrast that text needs against its ground (WCAG 2.2, level AA)."""
GREY = 0.3
"""Saturation below which a colour counts as grey, or as the tint of a ground."""
LIGHTEST, DARKEST = 0.92, 0.12
"""Lightness of what is black on white, and of what is white."""
STEP = 0.02


def dark_colour(colour: str) -> str:
    """Return what ``#rrggbb`` on white becomes on the dark ground, of the same hue."""
    hue, lightness, saturation = colorsys.rgb_to_hls(*_channels(colour))
    if saturation < GREY or lightness in (0.0, 1.0):
        return _hex(colorsys.hls_to_rgb(hue, LIGHTEST + (DARKEST - LIGHTEST) * lightness, saturation))
    while contrast(_hex(colorsys.hls_to_rgb(hue, lightness, saturation)), DARK_GROUND) < READABLE:
        lightness += STEP
    return _hex(colorsys.hls_to_rgb(hue, lightness, saturation))


def contrast(colour: str, ground: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2.2)."""
    light, dark = sorted((_luminance(colour), _luminance(ground)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def colour_rules(colours: Iterable[str], *, dark: bool) -> str:
    """Return the page's names of figures' colours: ``--c-004c80:#004c80;...``."""
    return "".join(f"--c-{one[1:]}:{dark_colour(one) if dark else one};" for one in sorted(set(colours)))


def _luminance(colour: str) -> float:
    red, green, blue = (_linear(channel) for channel in _channels(colour))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _linear(channel: float) -> float:
    return channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4  # noqa: PLR2004 - sRGB


def _channels(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def _hex(channels: Iterable[float]) -> str:
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels)


TEMPLATE, STYLE, SCRIPT = "page.html.j2", "page.css", "page.js"
TEMPLATES = "templates"


def render_page(page: Page) -> str:
    """Return the page as text; the same page gives the same bytes."""
    script = _resource(SCRIPT)
    pictures = [figure.picture for figure in figures_of(page.sections)]
    colours = {colour for one in pictures if isinstance(one, InlinePicture) for colour in one.colours}
    text = _environment().get_template(TEMPLATE).render(
        page=page,
        version=__version__,
        style=_resource(STYLE),
        script=script,
        script_hash=_hash(script),
        light=colour_rules(colours, dark=False),
        dark=colour_rules(colours, dark=True),
    )  # fmt: skip
    return printable(text)


def figures_of(sections: Sequence[Section]) -> Iterator[Figure]:
    """Yield the figures of sections and of the sections in them."""
    for section in sections:
        yield from (part for part in section.parts if isinstance(part, Figure))
        yield from figures_of(section.sections)


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("friction_audit.reporting.html", TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["kind"] = lambda part, name: type(part).__name__ == name
    return environment


def _resource(name: str) -> str:
    return files("friction_audit.reporting.html").joinpath(TEMPLATES, name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """Return what lets the browser run this script and no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
