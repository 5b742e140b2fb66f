"""A diagnosis's model.toml: the simulator makes another log of it, and a second diagnosis finds nothing missing."""

from pathlib import Path

import pytest

from friction_audit.effects.joint_model import load_model
from tests.cli.conftest import Run


@pytest.mark.usefixtures("sketched")
def test_a_grown_model_is_simulated_and_misses_nothing(run: Run, tmp_path: Path) -> None:
    words = ("--duration", "60", "-q")
    assert run("simulate", "joint", "-o", "first.parquet", "--seed", "5", "--effect", "stribeck", *words).code == 0
    few = ("--candidates", "stribeck,presliding,torque_bias", "--json")
    first = run("diagnose", "first.parquet", "-o", "first", *few).document()
    assert [effect["name"] for effect in first["joints"][0]["effects"]] == ["stribeck"]
    joint = load_model(tmp_path / "first" / "model.toml").joints[0]
    assert joint is not None
    assert joint.provenance.method == "diagnose"
    assert [term.name for term in joint.terms] == ["coulomb", "viscous", "stribeck"]
    model = ("--joint-model", "first/model.toml")
    assert run("simulate", "joint", "-o", "second.parquet", "--seed", "6", *model, *words).code == 0
    second = run("diagnose", "second.parquet", *model, *few).document()
    assert second["joints"][0]["verdict"] == "adequate"
