import csv
import json
from pathlib import Path

import pytest

from tests.in_this_process import Run
from tests.reporting.conftest import COULOMB


def spoiled(log: Path, path: Path, names: dict[str, str], rows: int | None = None, **columns: float) -> Path:
    """Write a log with other names, fewer rows, or columns that stand still."""
    lines = list(csv.DictReader(log.read_text().splitlines()))[:rows]
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names.get(name, name) for name in lines[0])
        writer.writerows((columns.get(name, cell) for name, cell in line.items()) for line in lines)
    return path


def test_a_dead_torque_has_a_reason_and_takes_no_other_joint_along(run: Run, logs: Path, tmp_path: Path) -> None:
    log = spoiled(logs / "moved2.csv", tmp_path / "dead.csv", {}, tau_interaction_2=0.0)
    answer = run("estimate", log, "--json")
    good, dead = answer.document()["joints"]
    assert answer.code == 0
    assert good["coulomb_nm"]["value"] == pytest.approx(COULOMB[0], abs=0.02)
    assert dead["coulomb_nm"] is None
    assert "torque" in dead["reason"]
    assert "dead" in dead["reason"]


def test_a_log_too_short_for_a_cycle_is_called_short(run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run("estimate", spoiled(logs / "moved1.csv", tmp_path / "log.csv", {}, rows=200))
    assert (answer.code, "the log lasts 0.8" in answer.err) == (4, True), answer
    assert "pause" not in answer.err


def test_the_estimator_of_the_paper_states_no_intervals(run: Run, logs: Path) -> None:
    text = run("estimate", logs / "moved1.csv", "--estimator", "paper").out
    assert ("95 %" in text, "no intervals" in text, "±" in text) == (False, True, False)
    run("report", logs / "moved1.csv", "--estimator", "paper", "--sections", "recording", "-o", "out")
    (page,) = Path("out").glob("*.html")
    assert "whole log with no intervals" in page.read_text()


@pytest.fixture
def amperes(logs: Path, tmp_path: Path) -> Path:
    return spoiled(logs / "moved1.csv", tmp_path / "current.csv", {"tau_interaction_1": "actual_current_1"})


@pytest.mark.usefixtures("sketched")
def test_motor_current_is_written_in_ampere(run: Run, amperes: Path, tmp_path: Path) -> None:
    answer = run("estimate", amperes, "-o", "out")
    assert (answer.code, "[A s/rad]" in answer.out) == (0, True), answer
    assert "N m" not in answer.out
    assert '"coulomb_a","coulomb_low_a"' in (tmp_path / "out" / "coefficient_history.csv").read_text()
    document = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert document["source"]["torque_unit"] == "A"
    assert "torque_in_ampere" in [warning["code"] for warning in document["warnings"]]
    assert "[A]" in run("replay", amperes).out


@pytest.mark.usefixtures("sketched")
def test_a_current_with_its_constant_is_in_newton_metres(run: Run, amperes: Path) -> None:
    constants = ("--torque-constant", "0.1", "--gear-ratio", "10")
    document = json.loads(run("estimate", amperes, *constants, "--json").out)
    plain = json.loads(run("estimate", amperes, "--json").out)
    assert document["source"]["torque_unit"] == "N m"
    assert document["settings"]["reading"]["gear_ratio"] == [10.0]
    assert "torque_converted" in [warning["code"] for warning in document["warnings"]]
    assert document["joints"][0]["coulomb_nm"]["value"] == pytest.approx(plain["joints"][0]["coulomb_nm"]["value"])
    assert run("estimate", amperes, "--torque-constant", "x").code == 2
