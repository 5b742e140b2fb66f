"""The page of a batch, in a browser: whole, quiet, readable at any width, by any means."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest

from friction_audit.reporting.batch_drawings import TITLES
from friction_audit.reporting.figures.batch import BATCH_FIGURES
from friction_audit.reporting.html import batch_page
from friction_audit.reporting.html.batch_page import write_page
from tests.opened_page import Opened
from tests.reporting import batch_by_hand as by_hand
from tests.reporting.html.batch_pages import hostile_page, plain_page, small_page
from tests.reporting.html.conftest import Open
from tests.reporting.html.paper import check_paper, check_window

THOROUGH = pytest.mark.thorough
SCHEMES = ("light", "dark")
CASES = (
    "hostile",
    *(pytest.param(case, marks=THOROUGH) for case in ("twenty joints", "plain", "one joint", "nothing")),
)
"""The worst, and those that are harmless beside it; a log of twenty joints is in ``test_log_page_in_browser.py``."""


@cache
def page_of(case: str) -> str:
    match case:
        case "hostile":
            return hostile_page()
        case "one joint":
            return write_page(by_hand.batch(by_hand.arm(3, 1, dated=False)))
        case "twenty joints":
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(batch_page, "TITLES", {"drift": TITLES["drift"]})
                return write_page(by_hand.batch(by_hand.arm(4, 20)))
        case "nothing":
            return write_page(by_hand.empty())
        case "small":
            return small_page()
    return plain_page()


@pytest.mark.parametrize("case", CASES)
def test_the_page_is_quiet_and_holds_at_any_width(open_page: Open, case: str) -> None:
    check_window(open_page(page_of(case)))


@pytest.mark.parametrize("case", CASES)
def test_paper_holds_everything(open_page: Open, case: str) -> None:
    check_paper(open_page, page_of(case))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_figure_is_there(open_page: Open, scheme: str) -> None:
    opened = open_page(page_of("plain"), scheme=scheme)
    boxes = opened.page.locator("figure svg")
    assert boxes.count() == len(BATCH_FIGURES)
    for k in range(boxes.count()):
        box = boxes.nth(k).bounding_box()
        assert box is not None
        assert box["width"] > 500
        assert box["height"] > 100
    names = opened.evaluate("[...document.querySelectorAll('figure svg title')].map((one) => one.textContent)")
    assert all("joint 2" in name for name in names)
    words = opened.page.locator("figure svg").nth(1).text_content() or ""
    assert "+15.0 ± 1.5 % at session 13" in words


@pytest.mark.parametrize("scheme", SCHEMES)
def test_colours_of_figures_are_the_page_s(open_page: Open, scheme: str) -> None:
    opened = open_page(page_of("plain"), scheme=scheme)
    ink = opened.evaluate("getComputedStyle(document.querySelector('figure svg text')).fill")
    assert ink == {"light": "rgb(0, 0, 0)", "dark": "rgb(235, 235, 235)"}[scheme]


def column(opened: Opened, number: int) -> list[str]:
    cells: list[str] = opened.evaluate(
        "(k) => [...document.querySelector('table.sortable').tBodies[0].rows].map((row) => row.cells[k].textContent)",
        number,
    )
    return cells


def test_a_table_is_sorted_by_mouse_and_by_keys(open_page: Open) -> None:
    opened = open_page(page_of("plain"))
    table = opened.page.locator("table.sortable").first
    change = table.get_by_role("button", name="change")
    change.click()
    head = table.locator("th[aria-sort]")
    assert head.get_attribute("aria-sort") == "ascending"
    assert column(opened, 3)[-4:] == ["+15.0 ± 1.5 %", "+23.0 ± 1.5 %", "-", "-"]
    change.focus()
    opened.page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") == "descending"
    assert column(opened, 3)[:2] == ["+23.0 ± 1.5 %", "+15.0 ± 1.5 %"]
    assert column(opened, 3)[-2:] == ["-", "-"]
    assert opened.page.locator("#said").text_content() == "Sorted by change, descending."
    table.get_by_role("button", name="verdict").click()
    assert column(opened, 2)[:2] == ["drift", "drift"]
    assert table.locator("th[aria-sort]").count() == 1


def until(opened: Opened, condition: str) -> None:
    """Wait for a condition; the page's policy keeps the browser from asking for it by itself."""
    for _ in range(250):
        if opened.evaluate(condition):
            return
        opened.page.wait_for_timeout(20)
    pytest.fail(f"never: {condition}")


def test_a_figure_is_enlarged_zoomed_moved_and_put_back(open_page: Open) -> None:
    opened = open_page(page_of("plain"))
    button = opened.page.get_by_role("button", name="Enlarge: Coefficients over the sessions")
    whole = opened.evaluate("document.querySelectorAll('figure svg')[1].getAttribute('viewBox')")
    button.click()
    dialog = opened.page.get_by_role("dialog")
    assert dialog.get_by_role("img").is_visible()
    inside = "document.querySelector('dialog svg').getAttribute('viewBox').split(' ').map(Number)"
    width = opened.evaluate(inside)[2]
    assert width >= float(whole.split()[2])
    dialog.get_by_role("button", name="Zoom in").click()
    left, _, zoomed, _ = opened.evaluate(inside)
    assert zoomed == pytest.approx(0.8 * width)
    opened.page.locator(".stage").focus()
    opened.page.keyboard.press("ArrowRight")
    assert opened.evaluate(inside)[0] == pytest.approx(left + 0.1 * zoomed)
    opened.page.mouse.move(640, 500)
    opened.page.mouse.wheel(0, -100)
    until(opened, f"{inside}[2] < {zoomed}")
    before = opened.evaluate(inside)[0]
    opened.page.mouse.down()
    opened.page.mouse.move(740, 500)
    opened.page.mouse.up()
    assert opened.evaluate(inside)[0] < before
    dialog.get_by_role("button", name="Whole figure").click()
    assert opened.evaluate(inside)[2] == pytest.approx(width)
    opened.page.keyboard.press("Escape")
    until(opened, "!document.querySelector('dialog svg')")  # it goes back after the key is dealt with
    assert opened.evaluate("document.querySelectorAll('figure svg').length") == len(BATCH_FIGURES)
    assert opened.evaluate("document.querySelectorAll('figure svg')[1].getAttribute('viewBox')") == whole
    assert opened.evaluate("document.activeElement.getAttribute('aria-label')").startswith("Enlarge: Coefficients")
    assert opened.complaints == []


def test_markup_in_names_is_text(open_page: Open) -> None:
    opened = open_page(page_of("hostile"))
    assert opened.evaluate("document.querySelectorAll('script').length") == 1
    assert opened.evaluate("document.querySelectorAll('alert, x').length") == 0
    shown = opened.page.locator("main").text_content() or ""
    assert by_hand.HOSTILE in shown
    assert by_hand.HOSTILE in (opened.page.locator("figure svg title").first.text_content() or "")
    assert opened.complaints == []


def test_the_page_can_be_read_without_scripts(open_page: Open) -> None:
    opened = open_page(page_of("plain"), scripts=False)
    assert opened.page.locator("table.sortable button, figure button").count() == 0
    assert opened.page.locator("figure svg").count() == len(BATCH_FIGURES)
    assert opened.page.locator("dialog").is_visible() is False


def test_the_contents_lead_to_every_section(open_page: Open) -> None:
    opened = open_page(page_of("plain"))
    targets = opened.evaluate("[...document.querySelectorAll('.contents a')].map((one) => one.hash.slice(1))")
    assert targets == opened.evaluate("[...document.querySelectorAll('main section')].map((one) => one.id)")
    ids = opened.evaluate("[...document.querySelectorAll('[id]')].map((one) => one.id)")
    assert len(ids) == len(set(ids))
    opened.page.keyboard.press("Tab")
    assert opened.evaluate("document.activeElement.className") == "skip"
    opened.page.keyboard.press("Enter")
    assert opened.evaluate("location.hash") == "#main"


@pytest.mark.parametrize(
    ("case", "scheme"),
    [
        ("small", "light"),
        ("hostile", "dark"),
        pytest.param("plain", "light", marks=THOROUGH),
        pytest.param("plain", "dark", marks=THOROUGH),
        pytest.param("hostile", "light", marks=THOROUGH),
    ],
)
def test_no_barrier_is_found(open_page: Open, case: str, scheme: str) -> None:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    source = (Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8")
    opened = open_page(page_of(case), scheme=scheme)
    opened.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    opened.evaluate(source)
    found: list[dict[str, Any]] = opened.evaluate("async () => (await axe.run()).violations")
    assert [(one["id"], [node["html"][:200] for node in one["nodes"][:3]]) for one in found] == []
