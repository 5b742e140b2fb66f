"""The page of one log from the command line: files, documents, exit codes, parts without an answer."""

import json
from pathlib import Path

import pytest

from friction_audit.errors import AnalysisError
from friction_audit.reporting import report as log_report
from tests.in_this_process import Run

NAMES = ("moved1.report.html", "moved1.report.json", "moved1.report.md")
PDF = "moved1.report.pdf"
WHY = "omnibus test: no candidate"


def no_answer(*_: object) -> None:
    raise AnalysisError(WHY)


@pytest.mark.usefixtures("sketched")
def test_every_format_is_written_and_the_document_is_the_file(run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run("report", logs / "moved1.csv", "-o", "out", "--format", "html,json,markdown,pdf", "--json")
    assert (answer.code, answer.err) == (0, ""), answer
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted((*NAMES, PDF))
    page, document, markdown = ((tmp_path / "out" / name).read_text(encoding="utf-8") for name in NAMES)
    assert json.loads(document) == answer.document()
    command = "friction-audit report moved1.csv --format html --format json --format markdown --format pdf "
    command += "--output out"
    assert answer.document()["command"] == command
    assert command in page
    assert command in markdown
    assert answer.document()["message"] in page
    assert all(str(logs) not in text for text in (page, document, markdown))
    assert (tmp_path / "out" / PDF).read_bytes().startswith(b"%PDF-")


def test_a_part_without_an_answer_leaves_the_others(run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_report, "diagnose_estimate", no_answer)
    answer = run("report", logs / "damaged.csv", "-o", "own.md")
    assert answer.code == 6
    lead, written = answer.out.splitlines()
    assert lead.startswith("Friction is estimated: Coulomb ")
    assert written == "own.md"
    assert "warning: " in answer.err
    text = Path("own.md").read_text(encoding="utf-8")
    assert WHY in text
    assert "that friction dissipated" in text


def test_sections_that_are_not_asked_for_are_not_computed(run: Run, logs: Path) -> None:
    document = run("report", logs / "moved1.csv", "--json", "--sections", "friction,recording").document()
    assert document["sections"] == ["friction", "recording"]
    assert (document["diagnose"], document["replay"], document["unanswered"]) == (None, None, [])


def test_json_alone_writes_no_file(run: Run, logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_report, "diagnose_estimate", no_answer)
    document = run("report", logs / "moved1.csv", "--json").document()
    assert document["unanswered"] == [{"part": "diagnose", "message": WHY}]
    assert document["joints"][0]["verdict"] == "estimated"
    assert list(tmp_path.iterdir()) == []
