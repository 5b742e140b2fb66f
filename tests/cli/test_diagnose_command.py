"""``diagnose``: names, options and parts of a log; what is wrong with one joint or part takes no answer from others."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.cli import chain
from friction_audit.diagnosis import diagnose as engine
from friction_audit.diagnosis.diagnose import diagnose_joint
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.io.writers.write_log import write_log
from friction_audit.reporting import report as log_report
from tests.each_case import with_thorough
from tests.in_this_process import Run
from tests.reporting.conftest import build_estimate

FEW = ("--candidates", "stribeck,torque_ripple")


@pytest.mark.usefixtures("sketched")
def test_a_hidden_effect_is_named_sized_and_added_to_the_model(run: Run, tmp_path: Path) -> None:
    clean: Any = build_estimate(1, count=40, rate=500.0).log
    hidden = 0.2 * np.sign(clean.dq) * np.exp(-np.abs(clean.dq) / 0.15)
    log = replace(clean, tau_interaction=clean.tau_interaction + hidden)
    write_log(log, tmp_path / "hidden.parquet")
    answer = run("diagnose", "hidden.parquet", "--candidates", "stribeck,torque_ripple", "-o", "out")
    assert answer.code == 0
    row, *_ = (line.split() for line in answer.out.splitlines() if line.startswith("1 "))
    assert row[1] == "named"
    assert float(row[2]) > 2.0 * float(row[3])
    assert "joint 1: missing: stribeck (" in answer.out
    joint = json.loads((tmp_path / "out" / "diagnose.json").read_text())["joints"][0]
    assert joint["effects"][0]["parameters"]["stribeck_excess_nm"] == pytest.approx(0.2, rel=0.1)
    assert joint["gap"]["shrink"] > 0.9
    assert "[joint.terms.stribeck]" in (tmp_path / "out" / "model.toml").read_text()


def test_options_reach_the_diagnosis(run: Run, logs: Path) -> None:
    words = ("--joints", "2", "--json", *FEW, "--seed", "3", "--min-effect", "0.2")
    document = run("diagnose", logs / "moved2.csv", *words).document()
    asked = document["settings"]["diagnosis"]
    assert (asked["seed"], asked["min_effect_nm"], asked["candidates"]) == (3, 0.2, ["stribeck", "torque_ripple"])
    (joint,) = document["joints"]
    assert (joint["joint"], joint["verdict"]) == (2, "adequate")
    assert joint["gap"]["baseline_rms_nm"] == pytest.approx(joint["gap"]["noise_floor_rms_nm"], rel=0.05)
    assert joint["nominal"]["coulomb_nm"]["value"] == pytest.approx(0.152, abs=0.01)


def test_a_process_of_its_own_which_works_in_copies_says_the_same(
    run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("diagnose", str(logs / "moved2.csv"), "--json", *FEW)
    command = [sys.executable, "-m", "friction_audit", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == (run(*words).out, "")
    monkeypatch.setattr(chain, "LARGE_LOG", 0)  # so that the log is read in the process that diagnoses it
    assert done.stdout == run(*words).out


def test_more_is_said_to_those_who_ask(run: Run, logs: Path) -> None:
    words = ("diagnose", logs / "moved1.csv", "--candidates", "stribeck,inertial_coupling")
    sentence = "this log cannot show inertial_coupling: no other joint moves"
    assert sentence in run(*words, "-v").out
    assert sentence not in run(*words).out


def test_of_a_long_log_a_part_is_diagnosed_and_that_is_said(run: Run, logs: Path) -> None:
    found = run("diagnose", logs / "moved1.csv", "--at-most", "0.5", "--json").document()
    (said,) = [one["message"] for one in found["warnings"] if one["code"] == "part"]
    assert said.startswith("only 30 s of 42 s are diagnosed, in parts from 0 to 42 s")
    assert found["joints"][0]["verdict"] == "adequate"


def fails(subject: Subject, *others: object) -> JointDiagnosis:
    """Diagnose a joint; of the first one the diagnosis ends in an error."""
    if subject.number == 1:
        raise ZeroDivisionError("by zero")
    return diagnose_joint(subject, *others)  # type: ignore[arg-type]


@pytest.mark.parametrize(("channel", "value"), [("tau_interaction", 0.37), ("dq", 0.0)])
def test_a_dead_channel_is_a_fault_of_its_joint(channel: str, value: float, run: Run) -> None:
    log = build_estimate(2, count=24, rate=250.0).log
    column = getattr(log, channel).copy()
    column[:, 1] = value  # other torques that are dead: tests/io/test_checks.py
    write_log(replace(log, **{channel: column}), Path("dead.csv"))
    answer = run("diagnose", "dead.csv", "--json", *FEW)
    assert answer.code == 0
    good, bad = answer.document()["joints"]
    assert (good["verdict"], bad["verdict"]) == ("adequate", "data_fault")
    assert "channel is dead" in bad["message"]
    assert good["nominal"]["coulomb_nm"]["value"] == pytest.approx(0.245, abs=0.01)


def test_a_bug_in_one_joint_is_its_own(run: Run, logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "diagnose_joint", fails)
    answer = run("diagnose", logs / "moved2.csv", "--json", *FEW)
    assert answer.code == 1
    bad, good = answer.document()["joints"]
    assert (bad["verdict"], good["verdict"]) == ("failed", "adequate")
    assert answer.err == f"error: joint 1: {bad['message']}\n"
    answer = run("diagnose", logs / "moved1.csv", "-v", *FEW)
    assert (answer.code, "failed" in answer.out) == (1, True)
    assert "Traceback (most recent call last)" in answer.err
    assert answer.err.splitlines()[-1].startswith("error: joint 1: the diagnosis failed with ZeroDivisionError")
    answer = run("report", logs / "moved1.csv", "--format", "markdown")
    assert (answer.code, "Traceback" in answer.err) == (1, False)
    page = (tmp_path / "moved1.report.md").read_text(encoding="utf-8")
    assert re.search(r"^\| 1 .*\| failed \|", page, re.MULTILINE)


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(("part", "stays"), [("replay", "What the model misses"), ("diagnose", "a compensator would")])
def test_a_bug_in_one_part_leaves_the_others_on_the_page(
    part: str, stays: str, run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_report, f"{part}_estimate", lambda *_: 1 / 0)
    answer = run("report", logs / "moved1.csv", "--format", "markdown,html,json")
    assert (answer.code, f"error: {part} failed with ZeroDivisionError" in answer.err) == (1, True), answer
    page = Path("moved1.report.md").read_text(encoding="utf-8")
    assert f"{part} failed with ZeroDivisionError" in page
    assert "Friction is estimated: " in page
    assert stays in page


def test_without_an_estimate_the_page_says_what_to_record(run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run("report", logs / "still.csv", "-o", "out", "--format", "html,markdown,json,pdf")
    assert (answer.code, "no joint has an estimate:\n  joint 1: did not move" in answer.err) == (4, True), answer
    assert len(list((tmp_path / "out").iterdir())) == 4
    page = (tmp_path / "out" / "still.report.md").read_text(encoding="utf-8")
    for said in ("Friction is estimated on no joint", "move back and forth", "SHA-256", "samples"):
        assert said in page.replace("Samples", "samples")


LOW = ((30.0, 0.45), (50.0, 0.15), (119.0, 0.45), (2000.0, 0.15))


@pytest.mark.parametrize(("rate", "share"), with_thorough(LOW, (30.0, 50.0, 119.0, 2000.0), (0.15, 0.45)))
def test_a_vibration_at_a_low_rate_is_no_error(rate: float, share: float, run: Run, tmp_path: Path) -> None:
    """Noise of the motion lowers the corner of the filter; a vibration above it is filtered away."""
    log: Any = build_estimate(1, count=24, rate=rate).log
    rng = np.random.default_rng(0)
    vibration = 0.1 * np.sin(2.0 * np.pi * share * rate * log.t)
    q, dq = (signal + size * rng.standard_normal(signal.shape) for signal, size in ((log.q, 1e-3), (log.dq, 1e-2)))
    write_log(replace(log, q=q, dq=dq, tau_interaction=log.tau_interaction + vibration[:, None]), tmp_path / "low.npz")
    answer = run("diagnose", "low.npz", "--json", "--candidates", "joint_elasticity,backlash,stribeck")
    assert answer.code == 0, answer.err
    (joint,) = answer.document()["joints"]
    assert joint["verdict"] in ("adequate", "named", "ambiguous", "unexplained")


@pytest.mark.parametrize("every", [25, 40])
def test_a_rate_at_which_too_few_samples_have_a_certain_direction_is_the_reason(
    every: int, run: Run, logs: Path
) -> None:
    header, *rows = (logs / "moved1.csv").read_text().splitlines(keepends=True)
    Path("slow.csv").write_text(header + "".join(rows[::every]))
    answer = run("diagnose", "slow.csv")
    assert answer.code == 4
    assert f"cycles at {250 / every:.3g} Hz; at least 50 are needed: record at 100 Hz or more" in answer.err
