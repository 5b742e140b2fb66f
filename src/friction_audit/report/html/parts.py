"""What a page is made of; every word in it is text and is escaped when the page is written."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from friction_audit.report.html.picture import Picture

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
