"""``compare`` and ``reproduce``: tables, documents and figures of simulations."""

from pathlib import Path

import pytest

from tests.in_this_process import Run

NO_MARGINS = ("--margin-persons", "0", "-q")
SHORT = ("--persons", "2", "--duration", "12", "--methods", "none,oracle", "-q")


@pytest.mark.usefixtures("sketched")
def test_table_and_figures(run: Run, tmp_path: Path) -> None:
    answer = run("compare", *SHORT, "-o", "out")
    assert (answer.code, answer.err) == (0, ""), answer
    assert "* no compensation" not in answer.out
    for word in ("oracle", "slope [mW]", "stable", "100%", ">32", "out/energy.png"):
        assert word in answer.out
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"energy.png", "velocity-torque.png", "summary.png"}


def test_document(run: Run) -> None:
    answer = run("compare", *SHORT, "--json", "--effect", "stribeck", "--set", "operator.inertia_kg_m2=0.2", "--ideal")
    document = answer.document()
    assert (document["arm"], document["seeds"], document["duration_s"]) == ("joint", [0, 1], 12.0)
    assert document["settings"]["operator"]["inertia_kg_m2"] == 0.2
    assert {effect["name"] for effect in document["effects"]} == {"stribeck", "joint_elasticity"}
    none, oracle = document["methods"]
    assert (none["method"], oracle["method"]) == ("none", "oracle")
    assert none["energy_slope_w"]["value"] > oracle["energy_slope_w"]["value"]
    assert none["stability_margin"] == {"value": None, "ci95": [None, None]}
    assert (none["stability_margins"], none["tuning_losses"], none["stable_share"]) == ([None, None], None, 1.0)
    assert document["margin_seeds"] == [0, 1]


@pytest.mark.usefixtures("sketched")
def test_sweep_is_reported_and_drawn(run: Run, tmp_path: Path) -> None:
    answer = run("compare", *SHORT[:5], "none,torque_regulation", *NO_MARGINS, "--json", "--figure-format", "svg")
    document = answer.document()
    assert document["margin_seeds"] == []
    assert [row["stability_margins"] for row in document["methods"]] == [[], [], []]
    (sweep,) = document["sweeps"]
    assert sweep["method"] == "torque_regulation"
    stable = [point["stable"] for point in sweep["points"]]
    assert [point["stable_share"] == 1.0 for point in sweep["points"]] == stable
    assert stable[0]
    assert not stable[-1]
    assert sweep["boldest_stable"] == [point["value"] for point in sweep["points"] if point["stable"]][-1]
    assert (tmp_path / "compared" / "sweep.svg").read_text().startswith("<?xml")


@pytest.mark.usefixtures("sketched")
def test_document_of_claims(run: Run, tmp_path: Path) -> None:
    answer = run("reproduce", "--figures", "7", "--figure-format", "svg", "--persons", "2", "--json")
    document = answer.document()
    assert document["seeds"] == 2
    assert [claim["figure"] for claim in document["claims"]] == ["7a", "7b", "7b", "7c", "7c"]
    assert all(claim["holds"] for claim in document["claims"])
    assert [figure["path"] for figure in document["figures"]] == ["reproduced/fig7.svg"]
    assert (tmp_path / "reproduced" / "fig7.svg").read_text().startswith("<?xml")


@pytest.mark.usefixtures("sketched")
def test_a_claim_that_does_not_hold_is_a_result(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.reproduce.checks.ESTIMATE_BOUND", 0.0)
    answer = run("reproduce", "--figures", "6", "-q")
    assert (answer.code, "0 of 3 claims of the paper hold" in answer.out) == (0, True), answer
    assert "NO" in answer.out
    assert "6: cycle 4 dissipates" in answer.out
