"""``replay``: what a compensator would have done, by the energy, by given coefficients, by the model of a joint."""

import json
import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance, save_model, simple_model
from friction_audit.joint_log import JointLog, LogInBlocks
from friction_audit.pipeline import Estimate, estimate_log
from tests import in_this_process
from tests.in_this_process import Run


def test_options_reach_the_compensator(run: Run, logs: Path) -> None:
    words = ("--joints", "2", "--json", "--compensator-window", "5", "--max-torque", "50")
    document = run("replay", logs / "moved2.csv", *words).document()
    assert document["settings"]["replay"]["compensator"]["window"] == 5
    (joint,) = document["joints"]
    assert joint["limits"] == {"torque_nm": 50.0, "rate_nm_s": None}
    assert joint["cycles"] == len(joint["history"])
    assert joint["energy_with_j"] < joint["energy_without_j"]


@pytest.mark.usefixtures("sketched")
def test_a_long_log_is_read_in_blocks_without_files(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[bool] = []

    def watched(log: JointLog, *arguments: Any) -> Estimate:
        read.append(isinstance(log, LogInBlocks))
        return estimate_log(log, *arguments)

    monkeypatch.setattr("friction_audit.pipeline.estimate_log", watched)
    monkeypatch.setattr("friction_audit.io.readers.table.IN_BLOCKS_BYTES", 0)
    log = Path(__file__).parents[2] / "sample_logs" / "hand_guided.parquet"
    table = run("replay", log).out
    assert run("replay", log, "-o", tmp_path / "whole", "--figures", "replay").out == table
    assert run("replay", log, "--assume", "same-torque").code == 0
    assert read == [True, False, False]


@pytest.mark.usefixtures("sketched")
def test_what_moves_otherwise_is_said_with_its_intervals(run: Run, logs: Path) -> None:
    options = ("--assume", "same-operator", "--operator", "0.3,9,60", "-o", "out")
    text = run("replay", logs / "moved1.csv", *options).out
    (joint,) = json.loads(Path("out/replay.json").read_text())["joints"]
    value, (low, high) = joint["fitted_joint"]["inertia_kg_m2"].values()
    assert low < value < high
    assert joint["operator"]["stiffness_nm_per_rad"] == {"value": 60.0, "ci95": [None, None]}
    number = r"[\d.]+ ± [\d.]+"
    assert re.search(f"joint 1 as fitted, 95 %: inertia {number} kg m², Coulomb {number} N m, viscous {number}", text)
    assert "person at joint 1 as given: inertia 0.3 kg m², damping 9 N m s/rad, stiffness 60 N m/rad" in text


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rig, a robot that moves by itself, and a rig whose torque falls with the speed."""
    folder = tmp_path_factory.mktemp("simulated")
    for name, words in {"rig": "joint", "robot": "joint-driven"}.items():
        assert in_this_process.run("simulate", words, "--duration", "30", "-o", folder / f"{name}.csv", "-q").code == 0
    falling = pd.read_csv(folder / "rig.csv")
    falling["tau_interaction_1"] -= 0.2 * falling["dq_1"]
    falling.to_csv(folder / "falling.csv", index=False)
    return folder


@pytest.mark.parametrize("assume", ["same-motion", "same-torque", "same-operator"])
def test_no_person_is_named_where_the_robot_moved_by_itself(assume: str, run: Run, simulated: Path) -> None:
    answer = run("replay", simulated / "robot.csv", "--assume", assume)
    assert "drive" in answer.out + answer.err
    assert "person" not in answer.out + answer.err


@pytest.mark.parametrize("drive", ["hand", "robot"])
def test_negative_viscous_friction_stays_visible_with_q(drive: str, run: Run, simulated: Path) -> None:
    answer = run("replay", simulated / "falling.csv", "-q", "--drive", drive)
    assert "negative viscous" in answer.out


@pytest.mark.usefixtures("sketched")
def test_signals_hold_the_torque_in_force_computed_a_sample_before(run: Run, simulated: Path, tmp_path: Path) -> None:
    given = ("--coefficients", "coulomb=0,viscous=0.05", "--no-passivity")
    assert run("replay", simulated / "rig.csv", *given, "--export", "csv", "-o", "out").code == 0
    rows = pd.read_csv(tmp_path / "out" / "replay_signals.csv")
    whole_nm = rows["interaction_with_nm"] + rows["compensation_nm"] + rows["passivity_nm"] + rows["limited_nm"]
    assert rows["compensation_nm"][1:].to_numpy() == pytest.approx(0.05 * rows["dq_without_rad_s"][:-1], abs=1e-9)
    assert whole_nm.to_numpy() == pytest.approx(rows["interaction_without_nm"], abs=1e-9)


@pytest.mark.usefixtures("sketched")
def test_the_history_file_holds_what_gives_its_coefficients(run: Run, simulated: Path, tmp_path: Path) -> None:
    answer = run("estimate", simulated / "rig.csv", "--estimator", "paper", "-o", "out/deep", "--json")
    rows, history = (
        pd.read_csv(tmp_path / "out/deep/coefficient_history.csv"),
        answer.document()["joints"][0]["history"],
    )
    assert rows["coulomb_nm"].to_list() == pytest.approx([point["coulomb_nm"] for point in history], nan_ok=True)
    columns, energy = rows[["path_rad", "square_speed_rad2_s"]].to_numpy(), rows["dissipated_j"].to_numpy()
    found = [np.linalg.solve(columns[k - 1 : k + 1], energy[k - 1 : k + 1]) for k in range(1, len(rows))]
    np.testing.assert_allclose(found, rows[["coulomb_nm", "viscous_nms_per_rad"]].to_numpy()[1:], rtol=1e-6, atol=1e-9)


def test_the_remedy_of_a_warning_is_the_user_s_own_command(run: Run, logs: Path) -> None:
    text = (logs / "moved1.csv").read_text()
    Path("run.csv").write_text(text.replace("tau_interaction_1", "felt", 1))
    own = "friction-audit replay run.csv --map tau_J=felt --drive robot"
    assert f"`{own} --urdf FILE`" in run(*own.split()[1:]).out


ORIGIN = Provenance(method="diagnose", log="first.parquet", sha256="ab", cycles=12)
SIMPLE = replace(simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07), provenance=ORIGIN)
STRIBECK = replace(SIMPLE, terms=(*SIMPLE.terms, FittedTerm("stribeck", (0.15, 0.1, 1.5))))
APPLIED = ("--compensator", "model", "--joint-model", "model.toml")


def save(*joints: JointModel | None, path: str = "model.toml") -> None:
    save_model(ArmModel(names=tuple(f"joint{k + 1}" for k in range(len(joints))), joints=joints), Path(path))


@pytest.fixture
def log(run: Run) -> str:
    """Return a log of the model with Stribeck friction, simulated from its file, which is left beside it."""
    save(STRIBECK)
    words = ("--joint-model", "model.toml", "--duration", "40", "-q")
    assert run("simulate", "joint", "-o", "run.parquet", "--seed", "5", *words).code == 0
    return "run.parquet"


def test_a_better_model_buys_more(run: Run, log: str) -> None:
    (energy,) = run("replay", log, "--json").document()["joints"]
    document = run("replay", log, *APPLIED, "--json").document()
    (better,) = document["joints"]
    assert energy["joint_model"] is None
    assert better["dissipation_removed"] > energy["dissipation_removed"] + 0.05
    assert better["compensator"]["kind"] == "joint_model"
    assert list(better["compensator"]["terms"]) == ["coulomb", "viscous", "stribeck"]
    assert document["settings"]["replay"]["joint_model"] == "model.toml"
    assert better["joint_model"]["provenance"] == asdict(ORIGIN)
    assert better["joint_model"]["terms"]["stribeck"]["stribeck_speed_rad_s"] == 0.1
    assert better["fitted_joint"] is None


def test_terms_that_tell_of_another_recording_are_named(run: Run, log: str) -> None:
    stepped = replace(STRIBECK, terms=(*STRIBECK.terms, FittedTerm("friction_step", (0.1, 0.0, 20.0, 0.0))))
    save(stepped, path="stepped.toml")
    message = "joint 1: friction_step of the model holds for moments of first.parquet, not of this log"
    assert message in " ".join(run("replay", log, *APPLIED[:3], "stepped.toml").err.split())
    save(replace(stepped, provenance=Provenance()), path="hand.toml")
    assert "moments" not in run("replay", log, *APPLIED[:3], "hand.toml").err


def test_a_joint_without_a_model_does_not_stop_the_others(run: Run, logs: Path) -> None:
    save(None, SIMPLE)
    answer = run("replay", logs / "moved2.csv", *APPLIED)
    assert (answer.code, "not replayed: joint 1: the model file has no model of it" in answer.out) == (0, True), answer
    assert "compensator: joint_model" in answer.out
    assert "joint 2 by model.toml" in answer.out
