import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from friction_audit.io.writers.write_log import write_log
from tests.cli.conftest import Run
from tests.reporting.conftest import build_estimate

FEW = ("--candidates", "stribeck,torque_ripple")


@pytest.mark.usefixtures("sketched")
def test_a_hidden_effect_is_named_sized_and_added_to_the_model(run: Run, tmp_path: Path) -> None:
    clean = build_estimate(1, count=40, rate=500.0).log
    assert clean.tau_interaction is not None
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


def test_a_process_of_its_own_which_works_in_copies_says_the_same(run: Run, logs: Path) -> None:
    words = ("diagnose", str(logs / "moved2.csv"), "--json", *FEW)
    command = [sys.executable, "-m", "friction_audit", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == (run(*words).out, "")


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
    assert run("diagnose", logs / "moved1.csv", "--at-most", "0").code == 2
