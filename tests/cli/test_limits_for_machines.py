"""``--strict`` and ``--junit``: what servers of continuous integration see of a result."""

import json
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest

from tests.cli.test_diff_command import joint, result
from tests.in_this_process import Run

AMPERE = ("--map", "tau_interaction=tau_interaction_{i}:A")


@pytest.mark.parametrize("command", ["estimate", "replay", "diagnose", "report", "plot"])
@pytest.mark.usefixtures("sketched")
def test_a_warning_of_physics_is_exit_5_after_all_is_written(command: str, run: Run, logs: Path) -> None:
    more = {"diagnose": ["--candidates", "stribeck"], "report": ["--sections", "friction"]}.get(command, [])
    words = [command, logs / "moved1.csv", *AMPERE, "-o", "out", "-q", *more]
    answer = run(*words, "--strict")
    assert answer.code == 5, answer
    assert answer.err == (
        f"error: --strict: warnings about the physics: {logs / 'moved1.csv'}: torque_in_ampere; expected none; the "
        "results are complete; do what the warnings say, or leave out --strict\n"
    )
    assert answer.out
    assert list(Path("out").iterdir())


def test_a_warning_of_physics_is_no_error_unasked_and_strictness_none_without_one(run: Run, logs: Path) -> None:
    words = ["estimate", logs / "moved1.csv", "-q"]
    assert run(*words, *AMPERE).code == 0
    assert run(*words, "--strict").code == 0


def test_a_warning_about_the_recording_is_none_of_physics(run: Run, logs: Path) -> None:
    assert run("estimate", logs / "damaged.csv", "--strict", "-q").code == 6
    answer = run("estimate", logs / "moved1.csv", *AMPERE, "--torque-constant", "0.1", "--strict")
    assert (answer.code, "a torque from a motor current" in answer.err + answer.out) == (0, True)  # as the user asked


@pytest.mark.usefixtures("here")
def test_strict_holds_for_each_session_of_a_batch_and_is_remembered(run: Run, logs: Path) -> None:
    Path("days").mkdir()
    for name in ("a", "b"):
        shutil.copy(logs / "moved1.csv", Path("days") / f"{name}.csv")
        with (Path("days") / f"{name}.csv").open("a") as file:
            file.write("\n" * (name == "b"))  # other content
    words = ["batch-report", "days", *AMPERE, "-q"]
    assert run(*words).code == 0
    for _ in range(2):  # the second time from the note in the ledger
        answer = run(*words, "--strict")
        assert answer.code == 5
        assert "physics: days/a.csv: torque_in_ampere; days/b.csv: torque_in_ampere; expected none" in answer.err
    assert Path("friction-drift/batch.json").exists()


def test_strict_takes_what_limits_a_comparison_and_what_its_results_warn_of(run: Run, tmp_path: Path) -> None:
    before = result(tmp_path / "a.json", joint(1, (0.30, 0.02), None, 11), count=1)
    after = result(tmp_path / "b.json", joint(1, (0.31, 0.02), None, 11), count=1, inertia="model")
    assert run("diff", before, after, "-q").code == 0
    answer = run("diff", before, after, "-q", "--strict")
    assert (answer.code, "the comparison: conditions_differ" in answer.err) == (5, True)
    document = json.loads(before.read_text())
    document["warnings"] = [{"code": "negative_viscous", "joint": 1, "message": "..."}]
    before.write_text(json.dumps(document))
    assert f"{before}: negative_viscous" in run("diff", before, before, "-q", "--strict").err


def cases(path: Path) -> dict[str, Any]:
    """Return the outcome of each test case: its first child."""
    return {str(one.get("name")): next(iter(one), None) for one in ET.parse(path).getroot().iter("testcase")}


def test_junit_has_a_case_for_each_joint_and_limit(run: Run, tmp_path: Path) -> None:
    still = joint(2, (0.2, 0.001), (0.1, 0.1), 21)
    before = result(tmp_path / "a.json", joint(1, (0.30, 0.01), (0.10, 0.01), 21), still)
    after = result(tmp_path / "b.json", joint(1, (0.36, 0.01), (0.10, 0.01), 21), still)
    limits = ["--fail-on", "coulomb=10%", "--fail-on", "joint2.viscous=20%", "--fail-on", "joint9.any=5%"]
    answer = run("diff", before, after, "-q", *limits, "--junit", "limits.xml")
    assert answer.code == 5
    root = ET.parse("limits.xml").getroot()
    assert [root.get(name) for name in ("tests", "failures", "errors")] == ["4", "1", "2"]
    assert [suite.get("name") for suite in root] == ["coulomb=10%", "joint2.viscous=20%", "joint9.any=5%"]
    found = cases(Path("limits.xml"))
    tags = {name: one is not None and one.tag for name, one in found.items()}
    assert tags == {
        "joint 1: Coulomb friction, limit coulomb=10%": "failure",
        "joint 2: Coulomb friction, limit coulomb=10%": "system-out",
        "joint 2: viscous friction, limit joint2.viscous=20%": "error",
        "limit joint9.any=5%": "error",
    }
    said = getattr(found["joint 1: Coulomb friction, limit coulomb=10%"], "text", "")
    assert f"limit exceeded: {said}" in answer.out
    assert "rose by 20 % (15 to 25 %)" in said


def test_junit_is_not_replaced_unasked_and_needs_a_limit(run: Run, tmp_path: Path) -> None:
    before = result(tmp_path / "a.json", joint(1, (0.30, 0.01), None, 21), count=1)
    words = ["diff", before, before, "-q", "--junit", "limits.xml"]
    assert run(*words).err == (
        "error: --junit limits.xml: there is no limit to write; give one with --fail-on, e.g. coulomb=15%\n"
    )
    Path("limits.xml").write_text("mine")
    answer = run(*words, "--fail-on", "coulomb=90%")
    assert (answer.code, "limits.xml: exists already" in answer.err) == (2, True)
    assert Path("limits.xml").read_text() == "mine"
    own = ["diff", before, before, "--junit", before, "--fail-on", "coulomb=90%", "--overwrite"]
    assert (run(*own).code, json.loads(before.read_text())["schema"]) == (2, "friction-audit/estimate/1")
    assert run(*words, "--fail-on", "coulomb=90%", "--overwrite").code == 0
    assert [one is not None and one.tag for one in cases(Path("limits.xml")).values()] == ["system-out"]


@pytest.mark.usefixtures("here")
def test_junit_of_a_batch_that_is_known_is_the_same(run: Run, logs: Path) -> None:
    words = ["batch-report", logs / "moved1.csv", "-q", "--fail-on", "coulomb=15%"]
    assert run(*words, "--junit", "first.xml").code == 7
    assert run(*words, "--junit", "second.xml").code == 7
    assert Path("first.xml").read_text() == Path("second.xml").read_text()
    (error,) = cases(Path("first.xml")).values()
    assert (error.tag, error.get("type")) == ("error", "untestable")
