"""Pages made by hand, each drawn once, and what must hold of any of them."""

import re
from collections.abc import Iterable
from functools import cache
from html.parser import HTMLParser

import pytest

from friction_audit.cli.parameters import BATCH_FIGURES
from friction_audit.reporting.drift import BatchSummary
from friction_audit.reporting.figures import figures_of
from friction_audit.reporting.html import batch_page, log_page as page_of_log
from friction_audit.reporting.html.batch_page import draw, drawings_of, write_page
from friction_audit.reporting.html.log_page import LOG_FIGURES, log_page
from friction_audit.reporting.html.page import Figure, render_page
from friction_audit.reporting.report import LogReport
from tests.reporting import batch_by_hand, log_report_by_hand

MOST_BYTES = 3_000_000
VOID = {"meta", "link", "br", "image", "use"}
SMALL = batch_by_hand.batch(batch_by_hand.arm(4, 2))


class Outline(HTMLParser):
    """The elements of a page: whether they are closed, the levels of headings, and addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.headings: list[int] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        if re.fullmatch(r"h[1-6]", tag) and "dialog" not in self.open:
            self.headings.append(int(tag[1]))
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag


def outline(html: str) -> Outline:
    parser = Outline()
    parser.feed(html)
    parser.close()
    assert parser.open == []
    return parser


def of_log(found: LogReport) -> str:
    return render_page(log_page(found))


def of_batch(summary: BatchSummary) -> str:
    every = ((one.anchor, draw(one)[1]) for one in drawings_of(summary.arms, {}, ()) if one.anchor)
    return write_page(summary, {anchor: figure for anchor, figure in every if figure is not None})


CASES = {
    "plain": lambda: of_log(log_report_by_hand.cut(log_report_by_hand.report(), 1, 3, 6)),
    "hostile": lambda: of_log(log_report_by_hand.hostile()),
    "twenty joints": lambda: of_log(log_report_by_hand.many(20)),
    "no cycles": lambda: of_log(log_report_by_hand.still()),
    "batch": lambda: of_batch(batch_by_hand.batch()),
    "batch hostile": lambda: of_batch(batch_by_hand.hostile()),
    "batch small": lambda: of_batch(SMALL),
    "batch twenty joints": lambda: of_batch(batch_by_hand.batch(batch_by_hand.arm(4, 20))),
    "batch nothing": lambda: of_batch(batch_by_hand.empty()),
}
"""Pages of a log, and of a batch."""


@cache
def page(case: str) -> str:
    """Return the page of a case; of twenty joints one figure is enough."""
    with pytest.MonkeyPatch.context() as patch:
        if "twenty" in case:
            patch.setattr(page_of_log, "LOG_FIGURES", LOG_FIGURES[1:2])
            patch.setattr(batch_page, "figures_of", lambda result: figures_of(result)[1:2])
        return CASES[case]()


def blank_figures(arms: int, *, letters: int, kinds: Iterable[str] = BATCH_FIGURES) -> dict[str, Figure]:
    """Return figures of so many arms of up to eight joints, by their anchors, each of so many letters."""
    svg = f"<svg>{'<g></g>' * (letters // 7)}</svg>"
    anchors = {f"arm-{number}-{kind}-1": kind for number in range(1, arms + 1) for kind in kinds}
    return {anchor: Figure(kind, "", svg, 100.0, "") for anchor, kind in anchors.items()}
