"""What a page is made of, as HTML, PDF and Markdown, and its drawings; every word in it is text, and escaped."""

import base64
import hashlib
import io
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from friction_audit import __version__
from friction_audit.errors import UsageError, printable
from friction_audit.reporting.figures.style import figure_style
from friction_audit.reporting.notices import sentences
from friction_audit.reporting.table import Column, Record, Table, Tone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing


class Figure(NamedTuple):
    """A figure that can be enlarged."""

    title: str  # what it shows, in a line
    caption: str  # how to read it
    svg: str  # its markup; the words in it are escaped
    width: float  # width at which its text is as large as it was drawn [pt]
    description: str  # what it shows, for those who do not see it


class Text(NamedTuple):
    """Sentences, a paragraph each, or the points of a list."""

    lines: Sequence[str]
    listed: bool = False
    tone: Tone = ""


class Command(NamedTuple):
    """A command to be typed, which can be copied."""

    line: str


class Terms(NamedTuple):
    """Names and values, side by side where there is room, or words and what they mean, a line each."""

    pairs: Sequence[tuple[str, str]]
    words: bool = False


Part = Table | Figure | Text | Command | Terms


class Section(NamedTuple):
    """A section with a heading, and sections in it."""

    anchor: str  # unique: ASCII letters, digits and hyphens
    title: str  # the heading
    parts: Sequence[Part] = ()  # what stands in it
    sections: Sequence["Section"] = ()  # sections in it, after the parts
    folded: bool = False  # whether a screen shows it only when asked for; paper shows it whole
    note: str = ""  # what stands next to the heading of a folded section
    on_paper: bool = True  # whether paper has it


class Page(NamedTuple):
    """A page: its title, its answer in a sentence or two, names and values of what it is about, and its sections."""

    title: str
    lead: str
    facts: Mapping[str, str] = MappingProxyType({})  # without those that are empty
    sections: Sequence[Section] = ()


PROGRAM = f"friction-audit {__version__}. The program is not by the authors of the method."
UNSET = "not set"
ON_A_SHEET = 8  # joints of one figure
SETTING = Record(Column("setting", str, get="0", code=True, on="p"), Column("value", str, get="1", code=True, on="p"))


def sheets_of(joints: Sequence[Any]) -> Iterator[tuple[Sequence[Any], str]]:
    """Yield the joints of each sheet of a figure, and which they are where there are several sheets, for its title."""
    for first in range(0, len(joints), ON_A_SHEET):
        own = joints[first : first + ON_A_SHEET]
        yield own, "" if len(own) == len(joints) else f", joints {own[0].joint} to {own[-1].joint}"


def closing_sections(
    words: Mapping[str, str], settings: Mapping[str, object], command: str, *, paper: bool = True
) -> Iterator[Section]:
    """Yield what the words of a page mean, on paper too, every setting and the command, and how to cite."""
    terms = (Terms(tuple(words.items()), words=True),)
    yield Section("words", "How to read it", terms, folded=True, on_paper=paper)
    table = SETTING.people(flattened(settings), caption="Every setting, defaults included", folded=True)
    again = (Text(("This command makes the page again:",)), Command(command)) if command else ()
    yield Section("settings", "Settings", (*again, table), folded=True)
    lead = "Friction is estimated from the energy balance between two moments of rest. When you publish, cite"
    cited = Text((sentences()["lines"]["method"], PROGRAM), listed=True)
    yield Section("cite", "How to cite", (Text((lead,)), cited), folded=True)


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


def _is_empty(one: Part | Section) -> bool:
    """Return True for what a page leaves out: tables without rows, texts without lines, sections of nothing else."""
    match one:
        case Table():
            return not one.rows
        case Text():
            return not one.lines
        case Section():
            return all(map(_is_empty, (*one.parts, *one.sections)))
    return False


def render_page(page: Page, *, paper: bool = False) -> str:
    """Return the page as HTML; for paper with sections open, without script and the long tables that a screen folds."""
    names = ("page.css", "page.js")
    style, script = (files(__package__).joinpath("templates", name).read_text(encoding="utf-8") for name in names)
    script = "" if paper else script
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()  # the browser runs no other script
    values = {"page": page, "paper": paper, "style": style, "script": script, "script_hash": digest}
    return printable(_environment().get_template("page.html.j2").render(values, version=__version__))


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader(__package__), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        autoescape=select_autoescape(("html.j2",)),  # in Markdown a filter escapes the words
    )  # fmt: skip
    environment.tests["kind"] = lambda part, name: type(part).__name__ == name
    environment.tests["empty"] = _is_empty
    # A fence of Markdown is longer than any run of backticks in the command.
    environment.filters["fence"] = lambda line: "`" * max(3, *(len(run) + 1 for run in re.findall("`+", line)), 0)
    # Text in one line that Markdown takes for nothing else.
    environment.filters["plain"] = lambda text: SPECIAL.sub(r"\\\1", " ".join(text.split()))
    return environment


# Characters that Markdown, its tables, its formulas or the HTML in it may take for something: an underscore, a hash or
# a plus only where no letter is before it.
SPECIAL = re.compile(r"([\\`*{}\[\]<>|~&$]|(?<!\w)[_#+]|_(?!\w))")


def write_pdf(page: Page) -> bytes:
    """Return a page as PDF: the page, printed."""
    try:
        from weasyprint import HTML
    except (ImportError, OSError) as error:  # OSError: without the library pango
        raise UsageError(
            f"--format pdf: WeasyPrint cannot be loaded ({error}); install it with: pip install 'friction-audit[pdf]' "
            "(on Debian and Ubuntu also: apt install libpango-1.0-0 libpangoft2-1.0-0); or print the HTML page"
        ) from error
    found: bytes = HTML(string=render_page(page, paper=True)).write_pdf(pdf_identifier=b"friction-audit")
    return found


def write_markdown(page: Page) -> str:
    """Return a page as Markdown, the same words and tables without drawings; names from the log stay text."""
    return printable(_environment().get_template("page.md.j2").render(page=page, version=__version__) + "\n")


SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
# A coordinate finer than a hundredth of a point is not visible; without it a page is a third smaller.
FINE = re.compile(r"\d+\.\d{3,}")
CURVE = "curve of "  # what the id of a curve begins with while it is drawn
CURVED = 33  # values that stand for an axis that is not linear
# Words as text: small, searchable and read aloud; clouds of dots, which are images, as fine as a screen shows them.
IN_PAGE: dict[Any, Any] = {"svg.fonttype": "none", "savefig.dpi": 120}


def draw_inline(figure: "Drawing", prefix: str, *, title: str, caption: str, description: str) -> Figure:
    """Return a figure as SVG to stand inside a page; every id in it begins anew with another prefix."""
    from matplotlib import rc_context

    stream = io.StringIO()
    with figure_style(), rc_context(IN_PAGE | {"svg.hashsalt": prefix}):
        for line in (line for axes in figure.axes for line in axes.lines):
            name = str(line.get_label())
            line.set_gid(None if line.get_rasterized() or name.startswith("_") else f"{CURVE}{name}")
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
        panels = [_panel(axes) for axes in figure.axes if axes.axison]
    root = ET.fromstring(printable(stream.getvalue()))  # noqa: S314 - drawn here, not read from anywhere
    for parent in root.iter():
        for child in [one for one in parent if one.tag.endswith(("metadata", "}style"))]:
            parent.remove(child)
    _trim(root)
    words = ET.Element(f"{{{SVG}}}title", {"id": f"{prefix}-title"})
    words.text = printable(description)
    root.insert(0, words)
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    about = {"role": "img", "aria-labelledby": f"{prefix}-title", "focusable": "false"}
    root.attrib |= {"data-panels": json.dumps(panels), **about}
    ET.register_namespace("", SVG)
    ET.register_namespace("xlink", XLINK)
    width = float(root.attrib["viewBox"].split()[2])
    return Figure(title, caption, ET.tostring(root, encoding="unicode"), width, description)


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


def _trim(root: ET.Element) -> None:
    """Name the curves, leave only the ids that something refers to, and round coordinates."""
    texts = [text for element in root.iter() for text in element.attrib.values()]
    used = {name for text in texts for name in re.findall(r"(?:^|url\()#([^)]+)", text)}
    for element in root.iter():
        name = element.attrib.pop("id", "")
        if name.startswith(CURVE):
            element.set("data-curve", printable(name.removeprefix(CURVE)))
        elif name in used:
            element.set("id", name)
        for key in {"d", "x", "y", "transform"}.intersection(element.attrib):
            element.set(key, FINE.sub(lambda x: f"{float(x[0]):.2f}".rstrip("0").rstrip("."), element.attrib[key]))
