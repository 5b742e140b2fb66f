"""Figures of the paper through ``main``."""

from pathlib import Path

import pytest

from tests.cli.conftest import Run


def test_table_figures_and_exit_code(run: Run, tmp_path: Path) -> None:
    answer = run("reproduce", "--figures", "3,6", "-o", "out", "-q")
    assert (answer.code, answer.err) == (0, "")
    assert "6 of 6 claims of the paper hold" in answer.out
    assert answer.out.endswith("out/fig3.png\nout/fig6.png\n")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["fig3.png", "fig6.png"]


@pytest.mark.usefixtures("sketched")
def test_document(run: Run, tmp_path: Path) -> None:
    answer = run("reproduce", "--figures", "7", "--figure-format", "svg", "--persons", "2", "--json")
    document = answer.document()
    assert document["seeds"] == 2
    assert [claim["figure"] for claim in document["claims"]] == ["7a", "7b", "7b", "7c", "7c"]
    assert all(claim["holds"] for claim in document["claims"])
    assert [figure["path"] for figure in document["figures"]] == ["reproduced/fig7.svg"]
    assert (tmp_path / "reproduced" / "fig7.svg").read_text().startswith("<?xml")


@pytest.mark.usefixtures("sketched")
def test_a_claim_that_does_not_hold_is_a_result(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.reproduce.one_joint.ESTIMATE_BOUND", 0.0)
    answer = run("reproduce", "--figures", "6", "-q")
    assert (answer.code, "0 of 3 claims of the paper hold" in answer.out) == (0, True), answer
    assert "NO" in answer.out
    assert "6: cycle 4 dissipates" in answer.out
