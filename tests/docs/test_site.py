"""The documentation as a site: built strictly, whole, as in the repository, asking for nothing; in a browser."""

import os
import re
import subprocess
import sys
from itertools import cycle
from pathlib import Path
from typing import NamedTuple

import pytest
from markdown_it import MarkdownIt

from friction_audit.diagnosis.result import VERDICTS
from tests.documented_commands import ROOT
from tests.each_case import with_thorough
from tests.opened_page import Open

DOCS = ROOT / "docs"
PAGES = tuple(sorted(DOCS.rglob("*.md")))
FROM_OUTSIDE = {"contributing": "CONTRIBUTING.md", "changelog": "CHANGELOG.md", "sample_logs": "sample_logs/README.md"}
OF_DOCS = [page.relative_to(DOCS) for page in PAGES]
SOURCES = {**{str(page.with_suffix("")): f"docs/{page}" for page in OF_DOCS}, **FROM_OUTSIDE}
COUNTED = ("table", "tr", "li", "ol", "ul", "pre", "p", "img", "em", "strong", "blockquote")
"""Elements that a writer means when writing Markdown; the two dialects differ in when they see them."""
LONGEST_PAGE, ALL_PAGES, LONGEST_README, LONGEST_CHANGELOG = 1900, 26_200, 1200, 1200  # words, tables included


class Site(NamedTuple):
    folder: Path
    code: int  # what the build ended with
    said: str  # what it said

    def page(self, name: str) -> Path:
        """Return the file of a page, ``effects/stribeck`` say."""
        return self.folder / f"{name}.html"


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    env = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    return Site(folder, done.returncode, done.stdout + done.stderr)


@pytest.fixture
def visit(open_address: Open, site: Site) -> Open:
    return lambda name, **look: open_address(site.page(name).as_uri(), **look)


def article(site: Site, name: str) -> str:
    """Return the text of a built page, without navigation."""
    found = re.search(r"<article[^>]*>(.*)</article>", site.page(name).read_text(), re.DOTALL)
    assert found is not None
    return found[1]


def count(html: str) -> dict[str, int]:
    return {tag: len(re.findall(f"<{tag}[ >]", html)) for tag in COUNTED}


def test_it_is_built_without_a_complaint(site: Site) -> None:
    assert (site.code, site.said) == (0, "")
    built = {str(page.relative_to(site.folder).with_suffix("")) for page in site.folder.rglob("*.html")}
    assert built == {*SOURCES, "404"}


@pytest.mark.parametrize("name", SOURCES)
def test_a_page_has_the_same_parts_as_in_the_repository(site: Site, name: str) -> None:
    markdown = (ROOT / SOURCES[name]).read_text()
    assert count(article(site, name)) == count(MarkdownIt("commonmark").enable("table").render(markdown))
    assert name in FROM_OUTSIDE or r"\|" not in article(site, name)  # code in tables is not escaped


def test_nothing_comes_from_elsewhere(site: Site) -> None:
    asked = [
        (page.name, tag)
        for page in site.folder.rglob("*.html")
        for tag in re.findall(r"<(?:script|link|img|iframe)[^>]+>", page.read_text())
        if re.search(r"(?:src|href)=.?(?:https?:)?//", tag)
    ]
    assert asked == []


def test_every_verdict_is_explained() -> None:
    section = (DOCS / "commands" / "diagnose.md").read_text().partition("## Verdicts")[2].partition("\n## ")[0]
    assert re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE) == list(VERDICTS)


def test_no_page_is_longer_than_anyone_reads() -> None:
    words = {page: len(page.read_text().split()) for page in PAGES}
    assert [page for page, count in words.items() if count > LONGEST_PAGE] == []
    assert sum(words.values()) <= ALL_PAGES
    assert len((ROOT / "README.md").read_text().split()) <= LONGEST_README
    assert len((ROOT / "CHANGELOG.md").read_text().split()) <= LONGEST_CHANGELOG


# In a browser, opened as files: quiet, readable at any width, in the dark, and searchable.

OPENED = ("index", "recording", "formats", "effects/stribeck")
MORE_PAGES = ("troubleshooting", "speed", "commands/diagnose", "sample_logs")
WINDOWS = ((360, "dark"), (1280, "light"), (1280, "dark"))
# Pages of every kind in a window, with every rule.
FAST = [*zip(OPENED, cycle(WINDOWS[:2]))]
COLOURS = ["color-contrast", "link-in-text-block"]


@pytest.mark.parametrize(("name", "window"), with_thorough(FAST, (*OPENED, *MORE_PAGES), WINDOWS))
def test_a_page_is_quiet_holds_its_width_and_has_no_barrier(visit: Open, name: str, window: tuple[int, str]) -> None:
    width, scheme = window
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
    # A key that is released before the script of the search listens is lost, on a busy machine.
    released = "document.querySelector('input.md-search__input').dispatchEvent(new KeyboardEvent('keyup'))"
    visited.page.wait_for_function(
        f"() => {released} && document.querySelector('.md-search-result__link')", timeout=60_000, polling=500
    )
    found = visited.page.locator(".md-search-result__link").first
    found.wait_for()
    assert "batch-report" in (found.get_attribute("href") or "")
    assert visited.complaints == []
