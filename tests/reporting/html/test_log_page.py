"""The page of a log: as text, as Markdown, as a document; and that it stays small."""

import json
import re
from dataclasses import replace
from functools import cache

import jsonschema
import numpy as np
import pytest
from friction_audit.reporting.html.log_part import part_of
from friction_audit.reporting.html.log_tables import gap_table
from friction_audit.reporting.json.diagnose import diagnose_document
from friction_audit.reporting.json.document import to_json, write_document
from friction_audit.reporting.json.estimate import estimate_document
from friction_audit.reporting.json.replay import replay_document
from friction_audit.reporting.json.report import log_document
from friction_audit.reporting.log_report import LogReport, Unanswered, report_notices
from friction_audit.reporting.log_words import lead_sentence, removal_words, verdict_sentence, verdict_word
from friction_audit.reporting.markdown import write_markdown

from friction_audit.reporting.figures.style import joint_title
from friction_audit.reporting.html import log_figures
from friction_audit.reporting.html.log_figures import LOG_FIGURES, draw_figures
from friction_audit.reporting.html.log_page import log_page, write_log_page
from friction_audit.reporting.schemas import load_schema
from tests.reporting import diagnosis_by_hand
from tests.reporting import log_report_by_hand as by_hand
from tests.reporting.html.test_page_text import MOST_BYTES, outline

WHY = "omnibus test: response or base holds values that are not finite"


@cache
def report() -> LogReport:
    return by_hand.report()


@cache
def page() -> str:
    return write_log_page(part_of(report(), (1, 3, 6)))


@cache
def hostile_page() -> str:
    return write_log_page(by_hand.hostile())


def without_parts() -> LogReport:
    missing = (Unanswered(part="diagnose", message=WHY), Unanswered(part="replay", message="no joint"))
    return replace(report(), diagnosis=None, replay=None, unanswered=missing)


def test_the_page_is_whole_small_and_points_nowhere() -> None:
    assert len(page().encode()) < MOST_BYTES
    parsed = outline(page().replace("<image ", "<use ").replace("<br>", ""))
    assert parsed.open == []
    assert [one for one in parsed.addresses if not one.startswith(("#", "data:"))] == []
    assert all(after - before <= 1 for before, after in zip(parsed.headings, parsed.headings[1:], strict=False))
    assert page().count('<figure class="drawing"') == len(LOG_FIGURES)
    ids = re.findall(r'\bid="([^"]+)"', page())
    assert len(ids) == len(set(ids))


def test_everything_that_must_be_on_it_is() -> None:
    log, choice = report().estimate.log, report().estimate.interaction.choice
    for said in (
        log.source.sha256,
        choice.formula,
        by_hand.LOST,
        diagnosis_by_hand.LIMIT,
        diagnosis_by_hand.FAULT,
        "nothing missing",
        "effect named",
        "data fault",
        "move it back and forth",
        "what stribeck does",
        "same-motion",
        "cycles.initiation_rad_s",
        "diagnosis.alpha",
        "replay.assume",
        "friction-audit report &#39;run 1.csv&#39; -o out",
        "10.1109/TMECH.2024.3410330",
    ):
        assert said in page(), said


def test_the_same_report_gives_the_same_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_figures, "LOG_FIGURES", LOG_FIGURES[1:2])
    one = part_of(report(), (1,))
    assert write_log_page(one) == write_log_page(one)


def test_each_joint_has_one_verdict_in_words() -> None:
    words = [verdict_word(one) for one in report().joints]
    assert words == ["effect named", "ambiguous", "nothing missing", "unexplained", "not testable", "data fault"]
    assert [verdict_word(one) for one in without_parts().joints] == [
        "estimated", "estimated", "no estimate", "estimated", "estimated", "estimated",
    ]  # fmt: skip


def test_a_joint_without_an_estimate_says_why() -> None:
    still = report().joints[2]
    sentence = verdict_sentence(still)
    assert sentence.startswith(f"No estimate: {still.friction.reason}.")
    assert "compensator" not in sentence


def test_a_verdict_says_friction_what_is_missing_and_what_would_be_saved() -> None:
    sentence = verdict_sentence(report().joints[0])
    removed = report().joints[0].replay
    assert removed is not None
    assert removed.numbers is not None
    assert re.match(r"Coulomb 0\.24\d* ± [\d.]+ N m, viscous 0\.[34]\d* ± [\d.]+ N m s/rad\. stribeck \(what", sentence)
    assert f"have removed {100 * removed.numbers.dissipation_removed:.0f} % of what friction took" in sentence


def test_a_compensator_that_makes_it_worse_says_so() -> None:
    joint = report().joints[0].replay
    assert joint is not None
    assert joint.numbers is not None
    worse = replace(joint, numbers=replace(joint.numbers, dissipation_removed=-0.5))
    assert removal_words(worse) == "a compensator would have left the person with 150 % of what friction took"
    lost = replace(joint, numbers=replace(joint.numbers, diverged_s=3.0))
    assert removal_words(lost) == "the compensator would have run away after 3 s"


def test_columns_that_say_nothing_are_left_out() -> None:
    assert "closed [%]" not in gap_titles(("none",))
    assert "closed [%]" in gap_titles(("none", "named"))


def gap_titles(verdicts: tuple[str, ...]) -> list[str]:
    found = report().diagnosis
    assert found is not None
    return list(gap_table(tuple(one for one in found.discrepancy.joints if one.verdict in verdicts)).titles)


def test_the_lead_names_the_joints() -> None:
    assert lead_sentence(report()).startswith("Friction is estimated on joints 1, 2, 4, 5 and 6 of 6. ")
    assert lead_sentence(part_of(report(), (1, 2))) == (
        "Friction is estimated on all 2 joints. The model misses stribeck on joint 1; "
        "the model misses torque_bias or asymmetric_coulomb on joint 2."
    )


def test_parts_without_an_answer_leave_the_others() -> None:
    html = write_log_page(part_of(without_parts(), (1,)))
    assert WHY in html
    assert "Velocity-torque curves." in html
    assert "How the gap shrank" not in html


def test_a_part_is_the_whole_cut_to_its_joints() -> None:
    whole, part = report().estimate, part_of(report(), (2, 6)).estimate
    assert part.interaction.joint_numbers == (2, 6)
    np.testing.assert_array_equal(part.interaction.dq[:, 1], whole.interaction.dq[:, 5])
    np.testing.assert_array_equal(part.cycles.of_joint(1).stop, whole.cycles.of_joint(5).stop)
    assert part.cycles.moving_s[1] == whole.cycles.moving_s[5]
    assert [one.joint for one in part.friction.joints] == [2, 6]


def test_a_name_that_says_only_the_number_is_not_cut_to_say_less() -> None:
    part = part_of(report(), (1,))
    assert report().joints[0].friction.name == "panda_joint1"
    assert part.diagnosis is not None
    assert part.replay is not None
    parts = (part.estimate.friction, part.diagnosis.discrepancy, part.replay.replay)
    assert [joint_title(one.joint, one.name) for found in parts for one in found.joints] == ["joint 1"] * 3


def test_figures_that_find_no_room_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_figures, "MOST_BYTES", 1)
    monkeypatch.setattr(log_figures, "ON_A_SHEET", 2)
    drawn = draw_figures(report())
    assert drawn.by_section == {}
    assert drawn.left_out["friction"][:3] == [
        "Coefficients over time, joints 1 to 2",
        "Velocity-torque curves, joints 1 to 2",
        "Net energy and cycles, joints 1 to 2",
    ]
    assert drawn.left_out["friction"][3] == "Coefficients over time, joints 3 to 4"
    assert "Coefficients over time, joints 3 to 4" in write_log_page(report())


def test_hostile_names_are_text() -> None:
    html = hostile_page()
    assert html.count("<script") == 1
    assert "&lt;script&gt;alert(" in html
    assert outline(html.replace("<image ", "<use ")).open == []
    text = write_markdown(log_page(by_hand.hostile(), None))
    outside = re.sub(r"^(`{3,})sh\n.*?\n\1$", "", text, flags=re.MULTILINE | re.DOTALL)
    assert not re.search(r"(?<!\\)[<>$]", outside)
    assert not re.search(r"(?<!\\)`", outside)


def test_figures_write_a_name_as_it_is() -> None:
    """As mathematics this name would be an error, and the font of the layout has no such letter."""
    name = "a$\\bad{$ \N{CJK UNIFIED IDEOGRAPH-819D}"
    assert f">joint 1 {name}</text>" in write_log_page(by_hand.called(name))


def test_markdown_holds_the_tables() -> None:
    text = write_markdown(log_page(report(), None))
    assert text.startswith("# Joint friction: run 1.csv\n")
    tables = re.findall(r"(?:^\|.*\|\n)+", text, re.MULTILINE)
    assert len(tables) >= 6
    for table in tables:
        bars = {len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}
        assert len(bars) == 1
    assert "```sh\nfriction-audit report 'run 1.csv' -o out\n```" in text
    assert "- **effect named** Joint 1: " in text


def test_the_document_holds_the_documents_of_its_parts() -> None:
    found = report()
    document = json.loads(write_document(log_document(found)))
    jsonschema.Draft202012Validator(load_schema("report")).validate(document)
    assert found.diagnosis is not None
    assert found.replay is not None
    wholes = {
        "estimate": estimate_document(found.estimate),
        "diagnose": diagnose_document(found.diagnosis),
        "replay": replay_document(found.replay),
    }
    for name, whole in wholes.items():
        assert document[name]["joints"] == to_json(whole["joints"]), name
        jsonschema.Draft202012Validator(load_schema(name)).validate(to_json(whole | document[name]))
    assert [one["code"] for one in document["warnings"]] == [one.code for one in report_notices(found)]
    assert document["settings"]["replay"] == to_json(wholes["replay"]["settings"]["replay"])
    empty = log_document(without_parts())
    assert empty["diagnose"] is None
    assert empty["unanswered"][0] == {"part": "diagnose", "message": WHY}
    jsonschema.Draft202012Validator(load_schema("report")).validate(json.loads(write_document(empty)))
