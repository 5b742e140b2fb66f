"""How the paper looks: its size, its letters, its colours."""

from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
from reportlab.lib.styles import ParagraphStyle
from reportlab.pdfbase.pdfmetrics import registerFont, registerFontFamily
from reportlab.pdfbase.ttfonts import TTFont

from friction_audit.reporting.html.page import Tone

SANS, BOLD, MONO = "DejaVuSans", "DejaVuSans-Bold", "DejaVuSansMono"
"""Letters that come with matplotlib and know nearly all scripts of Europe."""
MARGIN, FOOT = 45.0, 60.0
"""Margins at the sides and the top, and at the bottom. [pt]"""
INK, MUTED, LINE, HEAD = "#16191d", "#555b63", "#c9ced6", "#eef1f5"
TONES: dict[Tone, str] = {
    "": INK,
    "alert": "#9a3412",
    "fine": "#14603c",
    "unsure": "#6b4e00",
    "off": "#4a5159",
}
"""Colours of verdicts, those of the page by day."""


@cache
def register_letters() -> None:
    """Make the letters known."""
    folder = Path(mpl.get_data_path()) / "fonts" / "ttf"
    for name in (SANS, BOLD, MONO):
        registerFont(TTFont(name, str(folder / f"{name}.ttf")))
    registerFontFamily(SANS, normal=SANS, bold=BOLD, italic=SANS, boldItalic=BOLD)


def style(kind: str, **changed: object) -> Any:  # noqa: ANN401 - reportlab is untyped
    """Return the style of a kind of text, one of KINDS, changed as given."""
    register_letters()
    return ParagraphStyle(kind, **({"fontName": SANS, "textColor": INK, "splitLongWords": 1} | KINDS[kind] | changed))


KINDS: dict[str, dict[str, Any]] = {
    "title": {"fontName": BOLD, "fontSize": 16, "leading": 20, "spaceAfter": 6},
    "lead": {"fontSize": 10, "leading": 14, "spaceAfter": 8},
    "section": {"fontName": BOLD, "fontSize": 12.5, "leading": 16, "spaceBefore": 14, "spaceAfter": 5},
    "inner": {"fontName": BOLD, "fontSize": 10.5, "leading": 14, "spaceBefore": 9, "spaceAfter": 4},
    "caption": {"fontName": BOLD, "fontSize": 8, "leading": 10.5, "spaceBefore": 6, "spaceAfter": 3},
    "body": {"fontSize": 8.5, "leading": 12, "spaceAfter": 4},
    "note": {"fontSize": 7.5, "leading": 10, "textColor": MUTED, "spaceAfter": 8},
    "cell": {"fontSize": 6.8, "leading": 8.8},
    "number": {"fontSize": 6.8, "leading": 8.8, "alignment": 2},
    "head": {"fontName": BOLD, "fontSize": 6.5, "leading": 8.4},
    "code": {"fontName": MONO, "fontSize": 6.5, "leading": 8.8, "wordWrap": "CJK"},
    "command": {"fontName": MONO, "fontSize": 7.5, "leading": 10.5, "wordWrap": "CJK", "backColor": HEAD},
}
"""Kinds of text and what differs from the usual."""
