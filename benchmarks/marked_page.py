"""Tables that scripts write into pages, between two comments."""

from pathlib import Path


def write_between(page: Path, begin: str, end: str, text: str) -> None:
    """Put text between two marks of a page, in the place of what was there.

    Raises:
        ValueError: If the page does not hold both.
    """
    whole = page.read_text(encoding="utf-8")
    before, after = whole[: whole.index(begin)], whole[whole.index(end) :]
    page.write_text(f"{before}{begin}\n\n{text}\n\n{after}", encoding="utf-8")
