"""Pages of batches made by hand, each drawn once; figures that nobody draws, where only their room matters."""

from collections.abc import Iterable
from functools import cache

from friction_audit.reporting.batch_drawings import TITLES
from friction_audit.reporting.html.batch_page import write_page
from friction_audit.reporting.html.page import Figure
from friction_audit.reporting.html.svg import InlinePicture
from tests.reporting import batch_by_hand as by_hand

SMALL = by_hand.batch(by_hand.arm(4, 2))


@cache
def plain_page() -> str:
    return write_page(by_hand.batch())


@cache
def hostile_page() -> str:
    return write_page(by_hand.hostile())


@cache
def small_page() -> str:
    return write_page(SMALL)


def blank_figures(arms: int, *, letters: int, kinds: Iterable[str] = tuple(TITLES)) -> dict[str, Figure]:
    """Return figures of so many arms of up to eight joints, by their anchors, each of so many letters."""
    svg = f"<svg>{'<g></g>' * (letters // 7)}</svg>"
    picture = InlinePicture(svg=svg, width=100.0, description="", colours=frozenset())
    anchors = {f"arm-{number}-{kind}-1": kind for number in range(1, arms + 1) for kind in kinds}
    return {anchor: Figure(picture=picture, title=kind, caption="") for anchor, kind in anchors.items()}
