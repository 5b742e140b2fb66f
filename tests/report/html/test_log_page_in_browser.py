"""The page of a log, in a browser, at night: quiet, nothing overflows, no barrier; plain and with hostile names."""

from pathlib import Path
from typing import Any

import pytest

from friction_audit.report.html.log_figures import LOG_FIGURES
from tests.report import log_report_by_hand as by_hand
from tests.report.html.conftest import Open, Opened
from tests.report.html.test_log_page import hostile_page, page

NARROW = 360


def overflow(opened: Opened) -> int:
    """Return by how many pixels the page is wider than its window."""
    wider: int = opened.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    return wider


@pytest.mark.parametrize("case", ["plain", "hostile"])
def test_the_page_holds_in_a_browser(open_page: Open, case: str) -> None:
    opened = open_page(page() if case == "plain" else hostile_page(), scheme="dark")
    opened.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    assert overflow(opened) <= 0
    figures = opened.page.locator("figure svg")
    assert figures.count() == len(LOG_FIGURES)
    assert all((figures.nth(k).bounding_box() or {"height": 0})["height"] > 80 for k in range(figures.count()))
    drawn = "[...document.querySelectorAll('svg image')].every((one) => one.getBoundingClientRect().width > 10)"
    assert opened.evaluate(drawn)
    assert opened.evaluate("document.querySelectorAll('script').length") == 1
    if case == "hostile":
        assert by_hand.HOSTILE in (opened.page.locator("main").text_content() or "")
        assert barriers(opened) == []
    opened.page.set_viewport_size({"width": NARROW, "height": 900})
    assert overflow(opened) <= 0
    assert [one for one in opened.requests if not one.startswith("data:")] == opened.requests[:1]
    assert opened.complaints == []


def barriers(opened: Opened) -> list[Any]:
    """Return what the accessibility checker finds."""
    axe = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    opened.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = opened.evaluate("async () => (await axe.run()).violations")
    return [(one["id"], [node["html"][:200] for node in one["nodes"][:3]]) for one in found]
