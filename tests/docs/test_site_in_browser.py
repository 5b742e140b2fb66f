"""The site in a browser, opened as files: quiet, readable at any width, in the dark, and searchable."""

from itertools import cycle, product
from pathlib import Path

import pytest

from tests.opened_page import Open

PAGES = ("index", "recording", "formats", "troubleshooting", "effects/stribeck")
MORE_PAGES = ("speed", "commands/diagnose", "sample_logs")
WINDOWS = ((360, "dark"), (1280, "light"), (1280, "dark"))
FAST = [(name, *window) for name, window in zip(PAGES, cycle(WINDOWS[:2]))]
"""Pages of every kind in a window, with every rule."""
THOROUGH = [
    pytest.param(name, *window, marks=pytest.mark.thorough)
    for name, window in product((*PAGES, *MORE_PAGES), WINDOWS)
    if (name, *window) not in FAST
]
COLOURS = ["color-contrast", "link-in-text-block"]


@pytest.mark.parametrize(("name", "width", "scheme"), [*FAST, *THOROUGH])
def test_a_page_is_quiet_holds_its_width_and_has_no_barrier(visit: Open, name: str, width: int, scheme: str) -> None:
    visited = visit(name, width=width, scheme=scheme)
    assert visited.evaluate("document.documentElement.scrollWidth - window.innerWidth") <= 0
    assert visited.complaints == []
    assert {address.partition(":")[0] for address in visited.requests} <= {"file", "data", "blob"}
    axe = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    visited.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    rules = COLOURS if (width, scheme) == (1280, "dark") else None  # all else is as by day
    found = visited.evaluate("async (rules) => (await axe.run(rules ? {runOnly: rules} : {})).violations", rules)
    assert [(rule["id"], node["html"], node["failureSummary"]) for rule in found for node in rule["nodes"]] == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_follows_the_scheme_of_the_system_and_pictures_stand_on_white(visit: Open, scheme: str) -> None:
    visited = visit("effects/stribeck", scheme=scheme)
    colour = "getComputedStyle(document.querySelector('{}')).backgroundColor.match(/\\d+/g).slice(0, 3).map(Number)"
    ground = visited.evaluate(colour.format("body"))
    assert max(ground) < 80 if scheme == "dark" else min(ground) > 200
    assert visited.evaluate("document.querySelector('article img').naturalWidth") > 0
    assert visited.evaluate(colour.format("article img")) == [255, 255, 255]


def test_a_word_is_found_without_a_server(visit: Open) -> None:
    visited = visit("index")
    visited.page.locator("input.md-search__input").fill("manifest")
    found = visited.page.locator(".md-search-result__link").first
    found.wait_for(timeout=20_000)
    assert "batch-report" in (found.get_attribute("href") or "")
    assert visited.complaints == []
