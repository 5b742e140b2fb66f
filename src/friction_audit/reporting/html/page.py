"""What a page is made of, and its HTML; every word in it is text and is escaped when the page is written."""

import base64
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from friction_audit import __version__
from friction_audit.errors import printable
from friction_audit.reporting.html.svg import Picture
from friction_audit.reporting.table import Column, Record, Row, Table, Tone

if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """A figure that can be enlarged: the drawing, what it shows in a line, and how to read it."""

    picture: Picture
    title: str
    caption: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Text:
    """Sentences, a paragraph each, or the points of a list."""

    lines: Sequence[str]
    listed: bool = False
    tone: Tone = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Command:
    """A command to be typed, which can be copied."""

    line: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Terms:
    """Names and values, side by side where there is room, or words and what they mean, a line each."""

    pairs: Sequence[tuple[str, str]]
    words: bool = False


Part = Table | Figure | Text | Command | Terms


@dataclass(frozen=True, kw_only=True, slots=True)
class Section:
    """A section with a heading, and sections in it.

    Attributes:
        anchor: Unique: ASCII letters, digits and hyphens.
        title: The heading.
        parts: What stands in it.
        sections: Sections in it, after the parts.
        folded: Whether a screen shows it only when asked for; paper shows it whole.
        note: What stands next to the heading of a folded section.
        on_paper: Whether paper has it.
    """

    anchor: str
    title: str
    parts: Sequence[Part] = ()
    sections: Sequence["Section"] = ()
    folded: bool = False
    note: str = ""
    on_paper: bool = True


@dataclass(frozen=True, kw_only=True, slots=True)
class Page:
    """A page: its title, its answer in a sentence or two, names and values of what it is about, and its sections."""

    title: str
    lead: str
    facts: Sequence[tuple[str, str]] = ()
    sections: Sequence[Section] = ()


METHOD = (
    "H. T. Dinc, J.-K. Lee, J.-H. Ryu, Model-Free Energy-Based Friction Compensation for Industrial Collaborative "
    "Robots as Haptic Displays, IEEE/ASME Transactions on Mechatronics, 2024, doi 10.1109/TMECH.2024.3410330."
)
PROGRAM = f"friction-audit {__version__}. The program is not by the authors of the method."


def citation_section() -> Section:
    """Return how to cite."""
    lead = "Friction is estimated from the energy balance between two moments of rest. When you publish, cite"
    parts = (Text(lines=(lead,)), Text(lines=(METHOD, PROGRAM), listed=True))
    return Section(anchor="cite", title="How to cite", parts=parts, folded=True)


UNSET = "not set"
SETTING = Record(
    (
        Column("setting", str, get="0", title="setting", code=True, on="p"),
        Column("value", str, get="1", title="value", code=True, on="p"),
    )
)


def settings_section(settings: Mapping[str, object], command: str) -> Section:
    """Return every setting, defaults included, and the command."""
    table = SETTING.people(flattened(settings), caption="Every setting, defaults included", folded=True)
    again = (Text(lines=("This command makes the page again:",)), Command(line=command)) if command else ()
    return Section(anchor="settings", title="Settings", parts=(*again, table), folded=True)


def flattened(settings: Mapping[str, object], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield each setting with its full name, ``outer.inner``, and its value as text."""
    for name, value in settings.items():
        full = f"{before}{name}"
        if isinstance(value, Mapping) and value:
            yield from flattened(value, f"{full}.")
        else:
            yield full, _setting_text(value)


def _setting_text(value: object) -> str:
    match value:
        case None | {}:
            return UNSET
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:g}"
        case list() | tuple():
            return ", ".join(map(_setting_text, value)) or UNSET
    return str(value)


def terms_of(record: Record, row: Row, unit: str) -> Terms:
    """Return a row of a table as names and values, without what has no value."""
    table = record.people([row], unit=unit).filled()
    columns = [column for column in table.columns if column.name != "joint"]
    return Terms(pairs=[(column.head(unit), table.text(column, row)) for column in columns])


def render_page(page: Page, *, paper: bool = False) -> str:
    """Return the page as HTML; the same page gives the same bytes.

    Args:
        page: The page.
        paper: Whether it is to be printed: sections open, no script, without the long tables that a screen folds.
    """
    script = "" if paper else _resource("page.js")
    text = _environment().get_template("page.html.j2").render(
        page=page,
        paper=paper,
        version=__version__,
        style=_resource("page.css"),
        script=script,
        # Lets the browser run this script and no other.
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
    )  # fmt: skip
    return printable(text)


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("friction_audit.reporting.html"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["kind"] = lambda part, name: type(part).__name__ == name
    return environment


def _resource(name: str) -> str:
    return files("friction_audit.reporting.html").joinpath("templates", name).read_text(encoding="utf-8")
