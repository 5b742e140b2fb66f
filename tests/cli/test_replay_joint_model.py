"""``replay --joint-model``: from a simulated log to what the model buys, and what is said of files that do not fit."""

from dataclasses import asdict, replace
from pathlib import Path

import pytest

from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance, save_model, simple_model
from tests.cli.conftest import Run

ORIGIN = Provenance(method="diagnose", log="first.parquet", sha256="ab", cycles=12)
SIMPLE = replace(simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07), provenance=ORIGIN)
STRIBECK = replace(SIMPLE, terms=(*SIMPLE.terms, FittedTerm("stribeck", (0.15, 0.1, 1.5))))
OPERATOR = ("--assume", "same-operator", "--operator", "0.3,9,60")
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


@pytest.mark.usefixtures("sketched")
def test_the_model_of_a_diagnosis_is_taken(run: Run, log: str) -> None:
    assert run("diagnose", log, "--candidates", "stribeck", "-o", "found", "-q").code == 0
    words = ("--compensator", "model", "--joint-model", "found/model.toml", "--json")
    (joint,) = run("replay", log, *words).document()["joints"]
    assert joint["joint_model"]["provenance"]["method"] == "diagnose"
    assert list(joint["compensator"]["terms"]) == ["coulomb", "viscous", "stribeck"]
    assert joint["dissipation_removed"] > 0.97


def test_terms_that_tell_of_another_recording_are_named(run: Run, log: str) -> None:
    stepped = replace(STRIBECK, terms=(*STRIBECK.terms, FittedTerm("friction_step", (0.1, 0.0, 20.0, 0.0))))
    save(stepped, path="stepped.toml")
    message = "joint 1: friction_step of the model holds for moments of first.parquet, not of this log"
    assert message in " ".join(run("replay", log, *APPLIED[:3], "stepped.toml").err.split())
    save(replace(stepped, provenance=Provenance()), path="hand.toml")
    assert "moments" not in run("replay", log, *APPLIED[:3], "hand.toml").err


def test_the_joint_of_the_file_moves(run: Run, log: str) -> None:
    (fitted,) = run("replay", log, *OPERATOR, "--json").document()["joints"]
    document = run("replay", log, *OPERATOR, "--joint-model", "model.toml", "--json").document()
    (given,) = document["joints"]
    assert (fitted["fitted_joint"] is None, given["fitted_joint"] is None) == (False, True)
    assert given["model_error"] < fitted["model_error"]
    assert "the joint of the model file and that impedance move together" in document["assumes"]


def test_a_joint_without_a_model_does_not_stop_the_others(run: Run, logs: Path) -> None:
    save(None, SIMPLE)
    answer = run("replay", logs / "moved2.csv", *APPLIED)
    assert (answer.code, "not replayed: joint 1: the model file has no model of it" in answer.out) == (0, True), answer
    assert "compensator: joint_model" in answer.out
    assert "joint 2 by model.toml" in answer.out
