"""Pages in a browser: quiet, whole at any width, on paper, by day and night, by keys, without barriers."""

import re
from pathlib import Path
from typing import Any

import pytest

from friction_audit.reporting.figures import figures_of
from friction_audit.reporting.html.log_page import LOG_FIGURES
from tests.opened_page import Open, Opened
from tests.reporting.pages import page

THOROUGH = pytest.mark.thorough
HARMLESS = ("plain", "no cycles", "batch", "batch twenty joints", "batch nothing")
CASES = ("hostile", "twenty joints", "batch hostile", *(pytest.param(one, marks=THOROUGH) for one in HARMLESS))
"""The worst, and those that are harmless next to them."""
# Widths of a phone, a tablet and a laptop, and of A4 between margins of 14 mm at 96 dots to the inch. [px]
WIDTHS, PAPER = (360, 768, 1280, 1920), 688
# Tables that are wider than their column.
SCROLLED = """[...document.querySelectorAll('.scroll')].filter((one) => one.checkVisibility())
    .filter((one) => one.scrollWidth > one.clientWidth + 1).map((one) => one.getAttribute('aria-label'))"""
WIDE = """[...document.querySelectorAll('table, svg, pre')].filter((one) => one.checkVisibility())
    .filter((one) => one.getBoundingClientRect().right > window.innerWidth + 1).map((one) => one.outerHTML)"""

EMPTIED = "document.querySelectorAll('figure svg > :not(title, desc)').forEach((one) => one.remove())"


def overflow(opened: Opened) -> int:
    return int(opened.evaluate("document.documentElement.scrollWidth - window.innerWidth"))


def unfold(opened: Opened) -> None:
    opened.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")


@pytest.mark.parametrize("case", CASES)
def test_a_page_is_quiet_holds_at_any_width_and_on_paper(open_page: Open, case: str) -> None:
    opened = open_page(page(case), scheme="dark")
    for change, widths in ((lambda _: None, WIDTHS[::3]), (unfold, WIDTHS)):
        change(opened)
        for width in widths:
            opened.page.set_viewport_size({"width": width, "height": 900})
            assert overflow(opened) <= 0, width
            assert opened.evaluate(SCROLLED) == [], width
    opened.page.mouse.wheel(0, 3000)
    assert opened.requests[0].startswith("file:")
    assert [one for one in opened.requests if not one.startswith("data:")] == opened.requests[:1]
    assert opened.complaints == []
    assert opened.evaluate("document.querySelectorAll('script').length") == 1
    opened.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = false; })")
    opened.page.set_viewport_size({"width": PAPER, "height": 900})
    opened.page.emulate_media(media="print")
    opened.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert overflow(opened) <= 0
    assert opened.evaluate(WIDE) == []
    assert opened.evaluate("[...document.querySelectorAll('details')].every((one) => one.open)")
    assert opened.evaluate("getComputedStyle(document.body).color") == "rgb(22, 25, 29)"
    assert opened.page.pdf(format="A4")[:5] == b"%PDF-"


@pytest.mark.parametrize(
    ("case", "count", "scheme"), [("plain", len(LOG_FIGURES), "dark"), ("batch", len(figures_of("drift")), "light")]
)
def test_every_figure_is_there(open_page: Open, case: str, count: int, scheme: str) -> None:
    opened = open_page(page(case), scheme=scheme)
    unfold(opened)
    boxes = [one.bounding_box() for one in opened.page.locator("figure svg").all()]
    assert [(box["width"] > 300, box["height"] > 80) for box in boxes if box] == [(True, True)] * count
    shown = opened.evaluate("getComputedStyle(document.querySelector('figure svg')).filter")
    assert ("invert" in shown) == (scheme == "dark")
    names = opened.evaluate("[...document.querySelectorAll('figure svg title')].map((one) => one.textContent)")
    assert all("joint" in name for name in names)


def column(opened: Opened, number: int) -> list[str]:
    rows = "[...document.querySelectorAll('table')[2].tBodies[0].rows]"
    return list(opened.evaluate(f"(k) => {rows}.map((row) => row.cells[k].textContent)", number))


def test_a_table_is_sorted_by_mouse_and_by_keys(open_page: Open) -> None:
    opened = open_page(page("batch"))
    table = opened.page.locator("table.sortable").nth(2)
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
    opened = open_page(page("batch"))
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
    assert opened.evaluate("document.querySelectorAll('figure svg')[1].getAttribute('viewBox')") == whole
    assert opened.evaluate("document.activeElement.getAttribute('aria-label')").startswith("Enlarge: Coefficients")
    assert opened.complaints == []


def test_the_value_under_the_pointer_is_shown_and_a_page_can_be_read_without_scripts(open_page: Open) -> None:
    opened = open_page(page("plain"))
    box = opened.page.locator("figure svg").first.bounding_box()
    assert box is not None
    opened.page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 0.5 * box["height"])
    words = opened.page.locator(".value").text_content() or ""
    assert re.search(r"Velocity \[rad/s\]: .*\nInteraction torque \[N m\]: ", words)
    opened = open_page(page("plain"), scripts=False)
    assert opened.page.locator("table.sortable button, figure button").count() == 0
    assert opened.page.locator("figure svg").count() == len(LOG_FIGURES)
    assert opened.page.locator("dialog").is_visible() is False


def test_the_contents_lead_to_every_section(open_page: Open) -> None:
    opened = open_page(page("batch"))
    targets = opened.evaluate("[...document.querySelectorAll('.contents a')].map((one) => one.hash.slice(1))")
    assert targets == opened.evaluate("[...document.querySelectorAll('main > section')].map((one) => one.id)")
    opened.page.keyboard.press("Tab")
    assert opened.evaluate("document.activeElement.className") == "skip"
    opened.page.keyboard.press("Enter")
    assert opened.evaluate("location.hash") == "#main"
    opened.page.locator(".contents a", has_text="Settings").click()
    until(opened, "document.querySelector('#settings details').open")


@pytest.mark.parametrize(("case", "scheme"), [
    *(("plain", "light"), ("batch hostile", "dark")),
    *(pytest.param(one, "dark", marks=THOROUGH) for one in ("hostile", "batch", "batch small", "no cycles")),
])  # fmt: skip
def test_no_barrier_is_found(open_page: Open, case: str, scheme: str) -> None:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    opened = open_page(page(case), scheme=scheme)
    unfold(opened)
    if case != "plain":  # the insides of a drawing are the same on every page, and take half of the time
        opened.evaluate(EMPTIED)
    opened.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = opened.evaluate("async () => (await axe.run()).violations")
    assert [(one["id"], [node["html"][:200] for node in one["nodes"][:3]]) for one in found] == []
