"""The page of a log, in a browser: quiet, whole at any width, on paper, by day and night, without barriers."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from friction_audit.reporting.html.log_part import part_of

from friction_audit.reporting.html import log_figures
from friction_audit.reporting.html.log_figures import LOG_FIGURES
from friction_audit.reporting.html.log_page import write_log_page
from tests.opened_page import Opened
from tests.reporting import log_report_by_hand as by_hand
from tests.reporting.html.conftest import Open
from tests.reporting.html.paper import check_paper, check_window
from tests.reporting.html.test_log_page import hostile_page, page, report

NARROWEST_FIGURE = 300
THOROUGH = pytest.mark.thorough
CASES = (
    "hostile",
    "twenty joints",
    *(pytest.param(case, marks=THOROUGH) for case in ("plain", "one joint", "no cycles")),
)
"""The worst, and those that are harmless beside them."""
SCHEMES = ("light", "dark")


@cache
def page_of(case: str) -> str:
    match case:
        case "hostile":
            return hostile_page()
        case "one joint":
            return write_log_page(part_of(report(), (2,)))
        case "twenty joints":
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(log_figures, "LOG_FIGURES", LOG_FIGURES[1:2])
                return write_log_page(by_hand.many(20))
        case "no cycles":
            return write_log_page(by_hand.still())
    return page()


def unfold(opened: Opened) -> None:
    opened.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")


@pytest.mark.parametrize("case", CASES)
def test_the_page_is_quiet_and_holds_at_any_width(open_page: Open, case: str) -> None:
    opened = open_page(page_of(case))
    check_window(opened)
    assert opened.evaluate("document.querySelectorAll('script').length") == 1


@pytest.mark.parametrize("case", CASES)
def test_paper_holds_everything(open_page: Open, case: str) -> None:
    check_paper(open_page, page_of(case))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_figure_is_there(open_page: Open, scheme: str) -> None:
    opened = open_page(page_of("plain"), scheme=scheme)
    figures = opened.page.locator("figure svg")
    assert figures.count() == len(LOG_FIGURES)
    for k in range(figures.count()):
        box = figures.nth(k).bounding_box()
        assert box is not None
        assert box["width"] > NARROWEST_FIGURE
        assert box["height"] > 80
    drawn = "[...document.querySelectorAll('svg image')].every((one) => one.getBoundingClientRect().width > 10)"
    assert opened.evaluate(drawn)


def test_hostile_names_are_text(open_page: Open) -> None:
    opened = open_page(page_of("hostile"))
    assert by_hand.HOSTILE in (opened.page.locator("main").text_content() or "")
    assert opened.complaints == []


def test_a_log_without_cycles_says_why(open_page: Open) -> None:
    opened = open_page(page_of("no cycles"))
    said = opened.page.locator("body").text_content() or ""
    assert "Friction is estimated on no joint." in said
    assert "did not move" in said
    assert opened.page.locator("figure svg").count() == 0


def test_twenty_joints_have_a_verdict_each_and_figures_on_several_sheets(open_page: Open) -> None:
    opened = open_page(page_of("twenty joints"))
    assert opened.page.locator("#verdicts .badge").count() == 20
    assert opened.page.locator("figure svg").count() == 3


@pytest.mark.parametrize(
    ("case", "scheme"), [("plain", "light"), ("hostile", "dark"), pytest.param("no cycles", "dark", marks=THOROUGH)]
)
def test_no_barrier_is_found(open_page: Open, case: str, scheme: str) -> None:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    opened = open_page(page_of(case), scheme=scheme)
    unfold(opened)
    opened.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = opened.evaluate("async () => (await axe.run()).violations")
    assert [(one["id"], [node["html"][:200] for node in one["nodes"][:3]]) for one in found] == []
