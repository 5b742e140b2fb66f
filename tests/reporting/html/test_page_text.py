"""The page as text: parts, drawings, colours and settings, without any browser."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from friction_audit.reporting.html.log_part import flattened
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.reporting.figures.batch import BATCH_FIGURES
from friction_audit.reporting.figures.batch_drift import draw_drift
from friction_audit.reporting.figures.style import FILTERED, FITTED, RAW, REJECTED, SHADE
from friction_audit.reporting.html import batch_page
from friction_audit.reporting.html.batch_page import write_page
from friction_audit.reporting.html.page import (
    DARK_GROUND,
    Cell,
    Command,
    Page,
    Part,
    Section,
    Table,
    Text,
    colour_rules,
    contrast,
    dark_colour,
    render_page,
)
from friction_audit.reporting.html.svg import draw_inline
from tests.reporting import batch_by_hand as by_hand
from tests.reporting.html.batch_pages import SMALL, blank_figures, plain_page, small_page

MOST_BYTES = 3_000_000
VOID = {"meta", "link", "br"}


class Outline(HTMLParser):
    """The elements of a page: whether they are closed, and what stands in headings."""

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
        assert self.open.pop() == tag


def outline(html: str) -> Outline:
    parser = Outline()
    parser.feed(html)
    parser.close()
    return parser


def test_a_page_is_whole_small_and_points_nowhere() -> None:
    html = plain_page()
    assert len(html.encode()) < MOST_BYTES
    parsed = outline(html)
    assert parsed.open == []
    assert [one for one in parsed.addresses if not one.startswith(("#", "data:,"))] == []
    assert parsed.headings[0] == 1
    assert parsed.headings.count(1) == 1
    assert all(after - before <= 1 for before, after in zip(parsed.headings, parsed.headings[1:], strict=False))
    assert not re.search(r"@import|@font-face|url\((?!#)", html)


def test_a_page_of_a_thousand_sessions_is_small_and_says_what_it_leaves_out() -> None:
    of_few = blank_figures(1, letters=50_000, kinds=("curves", "changes"))  # they are no larger for many sessions
    html = write_page(by_hand.batch(by_hand.arm(1000)), of_few)
    assert len(html.encode()) < MOST_BYTES
    assert "the last 857 of 1000, all of them are in the tidy table" in html
    assert outline(html).open == []


def test_a_page_of_many_arms_is_small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_page, "MOST_BYTES", 50_000)  # the figures of one arm
    arms = [by_hand.arm(30, 7, robot=f"arm-{k}") for k in range(40)]
    html = write_page(by_hand.batch(*arms), blank_figures(40, letters=75_000))
    assert len(html.encode()) < MOST_BYTES
    assert "the last 21 of 30" in html


def test_the_same_batch_gives_the_same_page() -> None:
    assert write_page(SMALL) == small_page()


def test_everything_that_must_be_on_it_is() -> None:
    html = small_page()
    for said in (
        "drift.alpha",
        "0.05",
        "logs/broken.bag",
        "record it again",
        "friction-audit batch-report logs --fail-on coulomb=15% -o out",
        "10.1109/TMECH.2024.3410330",
        "Limit exceeded",
        "run_003.mcap",
        "damaged, part of it left out; 3 repeated rows were left out",
    ):
        assert said in html, said


@pytest.mark.parametrize("place", ["text", "cell", "title", "command", "caption"])
@given(word=st.text(alphabet="<>&\"'`=/ax\\{}%$", min_size=1))
def test_no_word_becomes_markup(place: str, word: str) -> None:
    parts: dict[str, Part] = {
        "text": Text(lines=(word,)),
        "cell": Table(caption="c", titles=("t",), rows=((Cell(text=word),),)),
        "title": Table(caption="c", titles=(word,), rows=()),
        "command": Command(line=word),
        "caption": Table(caption=word, titles=("t",), rows=(), folded=True),
    }
    html = render_page(Page(title=word, lead=word, sections=(Section(anchor="a", title=word, parts=(parts[place],)),)))
    parsed = outline(html)
    assert parsed.open == []
    assert set(parsed.addresses) == {"data:,", "#main", "#a"}
    assert html.count("<script") == 1


def test_a_column_of_phrases_keeps_room_for_them() -> None:
    table = Table(caption="What", titles=("joint", "where"), rows=[(Cell(text="1"), Cell(text="spread", words=True))])
    html = render_page(Page(title="a", lead="b", sections=(Section(anchor="a", title="c", parts=(table,)),)))
    assert '<td class="words">spread</td>' in html


def test_figures_that_find_no_room_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_page, "MOST_BYTES", 100_000)
    steady = replace(by_hand.arm(4, 1, robot="steady"), drift=False)
    drifting = replace(by_hand.arm(4, 2, robot="moving"), drift=True)
    html = write_page(by_hand.batch(steady, drifting), blank_figures(2, letters=20_000))
    assert html.count('<figure class="drawing"') == len(BATCH_FIGURES)
    assert "those of steady are in files beside it" in html


def test_an_arm_without_joints_has_a_page() -> None:
    assert "bare" in write_page(by_hand.batch(replace(by_hand.arm(4, 1, robot="bare"), joints=(), drift=False)))


def test_words_of_a_drawing_stay_words() -> None:
    picture = draw_inline(draw_drift(by_hand.arm(4, 2), None), prefix="f", description="a <b> & c")
    assert ">joint 2<" in picture.svg
    assert "a &lt;b&gt; &amp; c" in picture.svg
    assert "DejaVu" not in picture.svg
    assert "metadata" not in picture.svg
    assert "<style" not in picture.svg


def test_drawings_share_no_name_and_name_no_colour_of_their_own() -> None:
    figure = draw_drift(by_hand.arm(4, 1), None)
    one, other = (draw_inline(figure, prefix=prefix, description="d") for prefix in ("one", "other"))
    ids = [set(re.findall(r'id="([^"]+)"', picture.svg)) for picture in (one, other)]
    assert ids[0]
    assert not ids[0] & ids[1]
    referred = set(re.findall(r'(?:url\(|href=")#([^")]+)', one.svg))
    assert referred <= ids[0]
    assert not re.search(r"#[0-9a-f]{6}\b", one.svg)
    used = set(re.findall(r"var\(--c-([0-9a-f]{6})\)", one.svg))
    assert used == {colour[1:] for colour in one.colours}


def test_control_characters_in_names_can_be_drawn() -> None:
    arm = by_hand.arm(4, 1)
    bad = replace(arm, joints=(replace(arm.joints[0], name="a\x00\x1b[31m\u4f60"),))
    assert "\ufffd" in draw_inline(draw_drift(bad, None), prefix="f", description="d\x00").svg
    assert "\x00" not in write_page(by_hand.batch(bad))


def test_dark_colours_of_the_figures_can_be_seen() -> None:
    assert dark_colour("#000000") == "#ebebeb"
    assert contrast(dark_colour("#ffffff"), DARK_GROUND) < 1.2
    assert contrast(dark_colour(SHADE), DARK_GROUND) < 1.6
    for colour in (FILTERED, FITTED, RAW, REJECTED, "#009e73", "#0072b2", "#e69f00"):
        assert contrast(dark_colour(colour), DARK_GROUND) >= 4.5
    assert dark_colour(REJECTED) == REJECTED


def test_contrast_by_hand() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


def test_rules_name_each_colour_once() -> None:
    assert colour_rules(["#ffffff", "#000000", "#ffffff"], dark=False) == "--c-000000:#000000;--c-ffffff:#ffffff;"


def test_settings_are_named_in_full() -> None:
    settings = {"a": {"b": 1, "c": {"d": None}}, "e": [1, 2.5], "f": True, "g": {}, "h": ()}
    assert dict(flattened(settings)) == {
        "a.b": "1",
        "a.c.d": "not set",
        "e": "1, 2.5",
        "f": "yes",
        "g": "not set",
        "h": "not set",
    }
