"""Text that a page can hold: names in logs and of files may hold anything."""

import re

CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
"""Characters that neither HTML nor XML can hold."""


def printable_text(text: str) -> str:
    """Return text with control characters marked, and bytes of a file's name that are no letters spelt out."""
    return CONTROL.sub("\N{REPLACEMENT CHARACTER}", text.encode("utf-8", "backslashreplace").decode())
