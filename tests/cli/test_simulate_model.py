"""``simulate --joint-model``: from a model's file to a log, and back."""

from pathlib import Path

import numpy as np
import pytest

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, save_model, simple_model
from friction_audit.io.readers import read_log
from tests.cli.conftest import Run

STRIBECK = FittedTerm("stribeck", (0.15, 0.1, 2.0))
SIMPLE = simple_model(inertia_kg_m2=0.25, coulomb_nm=0.4, viscous_nms_per_rad=0.1)
MODEL = JointModel(inertia_kg_m2=0.25, terms=(*SIMPLE.terms, STRIBECK))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    save_model(ArmModel(names=("joint1",), joints=(MODEL,)), tmp_path / "model.toml")
    return tmp_path / "model.toml"


def test_the_log_is_one_of_the_model(run: Run, file: Path, tmp_path: Path) -> None:
    words = ("--joint-model", file, "--ideal", "--duration", "20", "--json")
    document = run("simulate", "joint", "-o", "run.parquet", *words).document()
    joint = document["settings"]["joints"][0]
    assert [joint[name] for name in ("inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad")] == [0.25, 0.4, 0.1]
    assert [effect["name"] for effect in document["effects"]] == ["stribeck"]
    assert document["effects"][0]["parameters"]["excess_nm"] == 0.15
    log = read_log(tmp_path / "run.parquet")
    assert log.tau_interaction is not None
    dq = log.dq[:, 0]
    motion = Motion(t=log.t, q=log.q[:, 0], dq=dq, ddq=np.gradient(dq, log.t))
    moving = np.abs(dq) > 0.02
    left = [log.tau_interaction[:, 0][moving] - model.torque(motion)[moving] for model in (SIMPLE, MODEL)]
    assert np.std(left[1]) < 0.1 * np.std(left[0])


def test_settings_and_effects_come_on_top(run: Run, file: Path) -> None:
    words = ("--joint-model", file, "--set", "coulomb_nm=0.2", "--effect", "time_delay", "--duration", "2", "--json")
    document = run("simulate", "joint", "-o", "run.parquet", *words).document()
    assert document["settings"]["joints"][0]["coulomb_nm"] == 0.2
    assert sorted(effect["name"] for effect in document["effects"]) == ["stribeck", "time_delay"]


def test_a_model_that_does_not_fit_is_refused(run: Run, file: Path, tmp_path: Path) -> None:
    answer = run("simulate", "panda", "-o", "run.parquet", "--joint-model", file)
    assert answer.code == 2
    assert f"--joint-model {file}: the model has 1 joints, the scenario 7; expected as many" in answer.err
    drift = JointModel(inertia_kg_m2=0.25, terms=(FittedTerm("torque_drift", (0.1, 0.0, 0.0, 0.0, 1.0)),))
    save_model(ArmModel(names=("joint1",), joints=(drift,)), tmp_path / "drift.toml")
    answer = run("simulate", "joint", "-o", "run.parquet", "--joint-model", "drift.toml")
    assert answer.code == 2
    assert "--joint-model drift.toml: the model's joint 1: torque_drift: the simulator has no equal of it" in answer.err
    assert not (tmp_path / "run.parquet").exists()
