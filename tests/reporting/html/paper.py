"""What a page must be in a window and on paper, whichever report it is of."""

from tests.opened_page import Opened
from tests.reporting.html.conftest import Open

WIDTHS = (360, 768, 1280)
"""Of a phone, a tablet, a laptop. [px]"""
PAPER_PX = 688
"""Width of A4 between margins of 14 mm, at 96 dots to the inch."""
WIDE = """[...document.querySelectorAll('table, svg, pre')].filter((one) => one.checkVisibility())
    .filter((one) => one.getBoundingClientRect().right > window.innerWidth + 1).map((one) => one.outerHTML)"""


def overflow(opened: Opened) -> int:
    """Return by how many pixels the page is wider than its window."""
    wider: int = opened.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    return wider


def check_window(opened: Opened) -> None:
    """Make the window as wide as a phone, a tablet and a laptop: nothing overflows, folded or not, and all is quiet."""
    for unfolded in (False, True):
        opened.evaluate(
            "(all) => document.querySelectorAll('details').forEach((one) => { one.open ||= all; })", unfolded
        )
        for width in WIDTHS:
            opened.page.set_viewport_size({"width": width, "height": 900})
            assert overflow(opened) <= 0, (width, unfolded)
    opened.page.mouse.wheel(0, 3000)
    assert opened.requests[0].startswith("file:")
    assert [one for one in opened.requests if not one.startswith("data:")] == opened.requests[:1]
    assert opened.complaints == []


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
