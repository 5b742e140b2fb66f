"""Pages as text: whole, small, closed to the network; every word in them is text."""

import re
import sys
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st

from friction_audit.errors import UsageError
from friction_audit.reporting.figures import figures_of
from friction_audit.reporting.figures.drift import DRIFT
from friction_audit.reporting.html import batch_page, log_page as page_of_log, page as html_page
from friction_audit.reporting.html.batch_page import write_page
from friction_audit.reporting.html.log_page import LOG_FIGURES, log_page
from friction_audit.reporting.html.page import Page, render_page, write_markdown, write_pdf
from friction_audit.reporting.report import lead_sentence
from friction_audit.reporting.table import Column, Table
from tests.reporting import batch_by_hand, diagnosis_by_hand, log_report_by_hand
from tests.reporting.log_report_by_hand import report
from tests.reporting.pages import MOST_BYTES, SMALL, blank_figures, of_batch, of_log, outline, page


@pytest.mark.parametrize(("case", "figures"), [("plain", len(LOG_FIGURES)), ("batch", len(figures_of("drift")))])
def test_a_page_is_whole_small_and_loads_nothing(case: str, figures: int) -> None:
    html = page(case)
    assert len(html.encode()) < MOST_BYTES
    parsed = outline(html)
    assert [one for one in parsed.addresses if not one.startswith(("#", "data:"))] == []
    assert (parsed.headings[0], parsed.headings.count(1)) == (1, 1)
    assert all(after - before <= 1 for before, after in zip(parsed.headings, parsed.headings[1:], strict=False))
    assert not re.search(r"@import|@font-face|url\((?!#)", html)
    assert html.count('<figure class="drawing"') == figures
    ids = re.findall(r'\bid="([^"]+)"', html)
    assert len(ids) == len(set(ids))


def test_everything_that_must_be_on_a_page_is() -> None:
    log, choice = report().estimate.log, report().estimate.interaction.choice
    words = [log.source.sha256, choice.formula, log_report_by_hand.LOST, diagnosis_by_hand.LIMIT, "did not move"]
    words += [diagnosis_by_hand.FAULT, "cycles.initiation_rad_s", "replay.assume"]
    words += ["friction-audit report &#39;run 1.csv"]
    batch = ["drift.alpha", "logs/broken.bag", "record it again", "Limit exceeded", "damaged, part of it left out"]
    doi = "10.1109/TMECH.2024.3410330"
    assert [one for one in (*words, doi) if one not in page("plain")] == []
    assert [one for one in (*batch, doi, batch_by_hand.batch().command) if one not in page("batch small")] == []


def test_the_same_result_gives_the_same_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_of_log, "LOG_FIGURES", LOG_FIGURES[1:2])
    one = log_report_by_hand.cut(report(), 1)
    assert of_log(one) == of_log(one)
    assert of_batch(SMALL) == page("batch small")
    drawn = blank_figures(1, letters=7)  # processes finish in any order
    assert write_page(SMALL, dict(reversed(drawn.items()))) == write_page(SMALL, drawn)


@pytest.mark.parametrize("place", ["text", "cell", "title", "command", "caption"])
@given(word=st.text(alphabet="<>&\"'`=/ax\\{}%$", min_size=1))
def test_no_word_becomes_markup(place: str, word: str) -> None:
    column = Column("a", str, get=lambda row: row, title="t")
    parts: dict[str, html_page.Part] = {
        "text": html_page.Text(lines=(word,)),
        "cell": Table(columns=(column,), rows=(word,), caption="c"),
        "title": Table(columns=(column._replace(title=word),), rows=("x",), caption="c"),
        "command": html_page.Command(line=word),
        "caption": Table(columns=(column,), rows=("x",), caption=word, folded=True),
    }
    section = html_page.Section(anchor="a", title=word, parts=(parts[place],))
    html = render_page(Page(title=word, lead=word, sections=(section,)))
    assert set(outline(html).addresses) == {"data:,", "#main", "#a"}
    assert html.count("<script") == 1


def test_hostile_names_are_text() -> None:
    html = page("hostile")
    assert html.count("<script") == 1
    assert "&lt;script&gt;alert(" in html
    outline(html)
    text = write_markdown(log_page(log_report_by_hand.hostile(), figures=False))
    outside = re.sub(r"^(`{3,})sh\n.*?\n\1$", "", text, flags=re.MULTILINE | re.DOTALL)
    assert not re.search(r"(?<!\\)[<>$`]", outside)


def test_a_drawing_has_words_a_description_and_its_own_ids() -> None:
    figure = DRIFT(batch_by_hand.arm(4, 2), None)
    words = {"title": "", "caption": "", "description": "a <b> & c\x00"}
    one, other = (html_page.draw_inline(figure, prefix, **words) for prefix in ("one", "other"))
    assert ">joint 2<" in one.svg
    assert "a &lt;b&gt; &amp; c\ufffd" in one.svg
    assert "metadata" not in one.svg
    assert "<style" not in one.svg
    ids = [set(re.findall(r'id="([^"]+)"', picture.svg)) for picture in (one, other)]
    assert ids[0]
    assert not ids[0] & ids[1]
    assert set(re.findall(r'(?:url\(|href=")#([^")]+)', one.svg)) <= ids[0]


def test_a_verdict_counts_without_an_estimate_and_a_regression_is_said() -> None:
    both = log_report_by_hand.cut(report(), 1, 2)
    first, second = both.estimate.friction.joints
    joints = (replace(first, reason=diagnosis_by_hand.NOT_TESTABLE.reason), replace(second, method="regression"))
    found = replace(both, estimate=replace(both.estimate, friction=replace(both.estimate.friction, joints=joints)))
    assert lead_sentence(found).startswith(
        "Friction is estimated on 1 of 2 joints: joint 2. The model misses Stribeck on joint 1;"
    )
    html = render_page(log_page(found, figures=False))
    assert "From torque regression, as too few energy cycles count: joint 2." in html


def test_the_lead_of_a_batch_claims_no_more_than_was_tested() -> None:
    assert "Drift of each arm" not in page("batch nothing")  # a table without rows
    steady, bare = batch_by_hand.arm(24, 1, robot="steady"), replace(batch_by_hand.arm(3, 1, robot="short"), joints=())
    assert "short: 3 comparable sessions, at least 4 are needed" in write_page(batch_by_hand.batch(bare), {})
    html = write_page(batch_by_hand.batch(steady, bare), {})
    assert "check lubrication" not in html
    assert "check lubrication" in write_page(batch_by_hand.batch(batch_by_hand.arm()), {})
    assert "No drift of the friction was found on 1 arm; no answer on 1 arm." in html
    assert "No answer on 2 arms." in write_page(batch_by_hand.batch(bare, replace(bare, robot="other")), {})
    (joint,) = steady.joints
    warmer = replace(joint, coefficients=tuple(replace(one, shape="temperature") for one in joint.coefficients))
    html = write_page(batch_by_hand.batch(steady, replace(steady, robot="warm", joints=(warmer,))), {})
    assert "was found on 1 arm; drift and temperature cannot be separated on warm." in html


def test_figures_that_find_no_room_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_page, "MOST_BYTES", 100_000)
    steady = batch_by_hand.arm(4, 1, robot="steady")
    drifting = batch_by_hand.arm(4, batch_by_hand.RISE_JOINT, robot="moving")
    bare = replace(batch_by_hand.arm(4, 1, robot="bare"), joints=())
    html = write_page(batch_by_hand.batch(steady, drifting, bare), blank_figures(2, letters=20_000))
    assert html.count('<figure class="drawing"') == len(figures_of("drift"))
    assert "those of steady are in files next to it" in html


def test_joints_beyond_a_sheet_are_on_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_of_log, "LOG_FIGURES", LOG_FIGURES[:1])
    monkeypatch.setattr(html_page, "ON_A_SHEET", 2)
    assert "Coefficients over time, joints 4 to 5" in of_log(replace(report()))  # drawn anew; joint 3 has none


@pytest.mark.thorough
def test_a_page_of_a_thousand_sessions_or_of_many_arms_is_small(monkeypatch: pytest.MonkeyPatch) -> None:
    of_few = blank_figures(1, letters=50_000, kinds=("curves", "changes"))  # they are no larger for many sessions
    html = write_page(batch_by_hand.batch(batch_by_hand.arm(1000)), of_few)
    assert len(html.encode()) < MOST_BYTES
    assert "the last 857 of 1000" in html
    monkeypatch.setattr(batch_page, "MOST_BYTES", 50_000)  # the figures of one arm
    arms = [batch_by_hand.arm(30, 7, robot=f"arm-{k}") for k in range(40)]
    html = write_page(batch_by_hand.batch(*arms), blank_figures(40, letters=75_000))
    assert len(html.encode()) < MOST_BYTES
    assert "the last 21 of 30" in html


def test_markdown_holds_the_tables() -> None:
    text = write_markdown(log_page(report(), figures=False))
    assert text.startswith("# Joint friction: run 1.csv\n")
    tables = re.findall(r"(?:^\|.*\|\n)+", text, re.MULTILINE)
    assert len(tables) >= 6
    for table in tables:
        assert len({len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}) == 1
    assert "```sh\nfriction-audit report 'run 1.csv' -o out\n```" in text
    assert "| named | missing: Stribeck " in text


def test_the_pdf_is_the_page_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    weasyprint = pytest.importorskip("weasyprint", reason="weasyprint is not installed", exc_type=ImportError)
    monkeypatch.setattr(page_of_log, "LOG_FIGURES", LOG_FIGURES[:2])
    found = log_page(log_report_by_hand.many(1, "a$b$ \N{CJK UNIFIED IDEOGRAPH-819D} <b>"))
    html = render_page(found, paper=True)
    assert not re.search("<script|<details>", html)
    printed = weasyprint.HTML(string=html).render()
    ((_, _, bookmarks, _),) = printed.make_bookmark_tree()
    titles = [section.title for section in found.sections if section.on_paper]
    assert [one[0] for one in bookmarks if one[0] != "Contents"] == titles
    assert 1 < len(printed.pages) < 5


def test_without_what_prints_it_one_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    with pytest.raises(UsageError, match=r"pip install 'friction-audit\[pdf\]'"):
        write_pdf(Page(title="a", lead="b"))
