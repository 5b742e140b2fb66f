"""The documentation as a site: built strictly, whole, the same as in the repository, asking for nothing."""

import re

import pytest
from markdown_it import MarkdownIt

from friction_audit.diagnosis.result import VERDICTS
from tests.docs.conftest import Site
from tests.documented_commands import ROOT

DOCS = ROOT / "docs"
PAGES = tuple(sorted(DOCS.rglob("*.md")))
FROM_OUTSIDE = {"contributing": "CONTRIBUTING.md", "changelog": "CHANGELOG.md", "sample_logs": "sample_logs/README.md"}
OF_DOCS = [page.relative_to(DOCS) for page in PAGES]
SOURCES = {**{str(page.with_suffix("")): f"docs/{page}" for page in OF_DOCS}, **FROM_OUTSIDE}
COUNTED = ("table", "tr", "li", "ol", "ul", "pre", "p", "img", "em", "strong", "blockquote")
"""Elements that a writer means when writing Markdown; the two dialects differ in when they see them."""
LONGEST_PAGE, LONGEST_README, LONGEST_CHANGELOG = 3000, 1200, 1500  # words, tables included


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
    assert len((ROOT / "README.md").read_text().split()) <= LONGEST_README
    assert len((ROOT / "CHANGELOG.md").read_text().split()) <= LONGEST_CHANGELOG
