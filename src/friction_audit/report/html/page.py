"""Page -> one HTML text that needs nothing else: no network, no other file, no font of its own."""

import base64
import hashlib
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from friction_audit import __version__
from friction_audit.printable import printable
from friction_audit.report.html.colours import colour_rules
from friction_audit.report.html.parts import Figure, Page, Section
from friction_audit.report.html.svg import InlinePicture

if TYPE_CHECKING:
    from jinja2 import Environment

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
        loader=PackageLoader("friction_audit.report.html", TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["kind"] = lambda part, name: type(part).__name__ == name
    return environment


def _resource(name: str) -> str:
    return files("friction_audit.report.html").joinpath(TEMPLATES, name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """Return what lets the browser run this script and no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
