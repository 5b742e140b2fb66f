"""What a page must be on paper, whichever report it is of."""

from tests.opened_page import Opened
from tests.report.html.conftest import Open

PAPER_PX = 688
"""Width of A4 between margins of 14 mm, at 96 dots to the inch."""
WIDE = """[...document.querySelectorAll('table, svg, pre')].filter((one) => one.checkVisibility())
    .filter((one) => one.getBoundingClientRect().right > window.innerWidth + 1).map((one) => one.outerHTML)"""


def overflow(opened: Opened) -> int:
    """Return by how many pixels the page is wider than its window."""
    wider: int = opened.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    return wider


def check_paper(open_page: Open, html: str) -> None:
    """Print a dark page: all of it is on the paper, unfolded, dark on white."""
    opened = open_page(html, width=PAPER_PX, scheme="dark")
    opened.page.emulate_media(media="print")
    opened.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert overflow(opened) <= 0
    assert opened.evaluate(WIDE) == []
    assert opened.evaluate("[...document.querySelectorAll('details')].every((one) => one.open)")
    assert opened.evaluate("getComputedStyle(document.body).color") == "rgb(22, 25, 29)"
    assert opened.page.pdf(format="A4")[:5] == b"%PDF-"
