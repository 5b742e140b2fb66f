"""``simulate``: a log and its truth, from a scenario or a model file; a model of a diagnosis misses nothing."""

import json
import shlex
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

import jsonschema
import pytest

from friction_audit.effects.joint_model import ArmModel, FittedTerm, load_model, save_model, simple_model
from friction_audit.effects.registry import FAMILIES
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import read_log
from friction_audit.io.writers.tables import Writer
from friction_audit.reporting.documents import load_schema
from friction_audit.simulation import Simulation, scenarios, simulate
from friction_audit.simulation.assign import paths
from friction_audit.simulation.bench import Progress
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.scenarios import SCENARIOS, AnySettings, Scenario
from tests.each_case import EACH_WRITER
from tests.in_this_process import Run

ONE = next(scenario for scenario in SCENARIOS if len(scenario.settings.joints) == 1).name
SEVEN = next(scenario for scenario in SCENARIOS if len(scenario.settings.moving) == 7).name
SHORT = ("--duration", "0.6", "-q")
EACH_SCENARIO = pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda scenario: scenario.name)


@EACH_SCENARIO
def test_every_scenario_gives_a_log(scenario: Scenario, run: Run, tmp_path: Path) -> None:
    answer = run("simulate", scenario.name, "-o", "run.parquet", "--duration", "1.5", "--json", "--truth", "t.json")
    assert (answer.code, answer.err) == (0, "")
    document, log = answer.document(), read_log(tmp_path / "run.parquet")
    assert (document["scenario"], document["seed"]) == (scenario.name, 0)
    output = document["output"]
    assert output["sha256"] == sha256_of(tmp_path / "run.parquet")
    assert (output["dialect"], output["joints"]) == ("parquet", len(scenario.settings.joints))
    assert output["rate_hz"] == pytest.approx(log.rate_hz, rel=0.02)
    assert document["joint_names"] == list(log.joint_names)
    assert document["settings"]["duration_s"] == 1.5
    assert log.duration_s == pytest.approx(1.5, abs=0.1)
    truth = json.loads((tmp_path / "t.json").read_text())
    jsonschema.Draft202012Validator(load_schema("truth")).validate(truth)
    assert all(truth[key] == document[key] for key in ("scenario", "seed", "settings", "effects"))
    assert truth["log_sha256"] == output["sha256"]


simulated = cache(simulate)


@pytest.fixture
def simulated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulate the same settings and seed once: what matters here is how it is written."""

    def once(settings: AnySettings, seed: int, *, path: str, progress: Progress | None) -> Simulation:
        assert progress is None  # nobody watches
        found = simulated(settings, seed)
        return replace(found, log=replace(found.log, source=replace(found.log.source, path=path)))

    monkeypatch.setattr(scenarios, "simulate", once)


@pytest.mark.usefixtures("simulated_once")
@EACH_WRITER
def test_no_dialect_holds_a_trace_of_the_truth(writer: Writer, run: Run, tmp_path: Path) -> None:
    effects = ("--effect", "stribeck", "--effect", "torque_bias@2")

    def written(folder: str, seed: int) -> Path:
        out = Path(folder) / f"run{writer.suffix}"
        words = ("-o", out, "--dialect", writer.name, "--seed", seed, *SHORT, *effects)
        assert run("simulate", SEVEN, *words).code == 0
        return tmp_path / out

    out = written("a", 3)
    assert sha256_of(out) == sha256_of(written("b", 3)) != sha256_of(written("c", 4))
    scenarios = [scenario.name for scenario in SCENARIOS if "-" in scenario.name]  # any log may say joint and panda
    traces = ("truth", "simulat", "scenario", "effect", "hidden", *scenarios, *(effect.name for effect in EFFECTS))
    log = read_log(out)
    told = f"{log.joint_names} {log.source.topic} {log.source.channels}".lower().encode()
    for file in sorted(file for file in out.rglob("*") if file.is_file()) or [out]:
        content = file.read_bytes().lower() + told
        assert [trace for trace in traces if trace.encode() in content] == [], file.name


def test_channels_without_a_place_are_named(run: Run) -> None:
    answer = run("simulate", SEVEN, "-o", "run.mcap", "--duration", "2")
    assert answer.out == "run.mcap\n"
    assert "warning: run.mcap: the dialect mcap has no place for tau_J_d" in answer.err
    document = run("simulate", SEVEN, "-o", "run.mcap", "--duration", "2", "--json", "--overwrite").document()
    assert [warning["code"] for warning in document["warnings"]] == ["channels_left_out"]


def test_settings_and_effects_are_what_was_asked_for(run: Run) -> None:
    words = "--duration 2 --rate 500 --seed 9 --set joints.coulomb_nm=0.4@2,5 --effect stribeck:excess_nm=0.2@3 --json"
    document = run("simulate", SEVEN, "-o", "run.parquet", *shlex.split(words)).document()
    assert document["seed"] == 9
    assert document["output"]["rate_hz"] == pytest.approx(500, rel=0.05)
    coulomb = [joint["coulomb_nm"] for joint in document["settings"]["joints"]]
    assert [number for number, value in enumerate(coulomb, start=1) if value == 0.4] == [2, 5]
    (effect,) = document["effects"]
    assert (effect["joint"], effect["name"], effect["parameters"]["excess_nm"]) == (3, "stribeck", 0.2)


@pytest.mark.parametrize(("step", "error", "code"), [
    ("simulation.scenarios.simulate", KeyboardInterrupt, 130),
    ("reporting.documents.write_document", KeyboardInterrupt, 130),
    ("reporting.documents.write_document", OSError, 2),
])  # fmt: skip
def test_an_interruption_leaves_nothing_and_no_log_without_its_truth(
    step: str, error: type[BaseException], code: int, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> NoReturn:
        raise error("in the middle of it")

    monkeypatch.setattr(f"friction_audit.{step}", fail)
    answer = run("simulate", ONE, "-o", "run.csv", "--truth", "run.json", *SHORT)
    assert (answer.code, "run.json: cannot be written: " in answer.err) == (code, error is OSError)
    assert list(tmp_path.iterdir()) == []


@EACH_SCENARIO
def test_settings_of_a_scenario_are_listed(scenario: Scenario, run: Run) -> None:
    head, *lines = run("simulate", scenario.name, "--list").out.splitlines()
    assert head.startswith(f"{scenario.name}: {scenario.summary}")
    assert [line.split()[0] for line in lines] == list(paths(scenario.settings))


def test_effects_are_listed_with_their_parameters(run: Run) -> None:
    lines = run("simulate", "--list-effects").out.splitlines()
    words = [line.split()[0] for line in lines]
    assert set(FAMILIES) <= set(lines)
    for effect in EFFECTS:
        assert f"{effect.name}:" in words
        assert {parameter.name for parameter in effect.parameters()} <= set(words)
        assert all(form in " ".join(lines) for form in effect.forms)


def test_the_joint_is_that_of_the_model_and_settings_and_effects_come_on_top(run: Run) -> None:
    simple = simple_model(inertia_kg_m2=0.25, coulomb_nm=0.4, viscous_nms_per_rad=0.1)
    model = replace(simple, terms=(*simple.terms, FittedTerm("stribeck", (0.15, 0.1, 2.0))))
    save_model(ArmModel(names=("joint1",), joints=(model,)), Path("model.toml"))
    words = ("--joint-model", "model.toml", "--duration", "2", "--json")
    document = run("simulate", "joint", "-o", "run.parquet", *words).document()
    joint = document["settings"]["joints"][0]
    assert [joint[name] for name in ("inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad")] == [0.25, 0.4, 0.1]
    assert [effect["name"] for effect in document["effects"]] == ["stribeck"]
    assert document["effects"][0]["parameters"]["excess_nm"] == 0.15
    more = ("--set", "coulomb_nm=0.2", "--effect", "time_delay", "--overwrite")
    document = run("simulate", "joint", "-o", "run.parquet", *words, *more).document()
    assert document["settings"]["joints"][0]["coulomb_nm"] == 0.2
    assert sorted(effect["name"] for effect in document["effects"]) == ["stribeck", "time_delay"]


@pytest.mark.usefixtures("sketched")
def test_a_grown_model_is_simulated_and_misses_nothing(run: Run, tmp_path: Path) -> None:
    words = ("--duration", "60", "-q")
    assert run("simulate", "joint", "-o", "first.parquet", "--seed", "5", "--effect", "stribeck", *words).code == 0
    few = ("--candidates", "stribeck,presliding,torque_bias", "--json")
    first = run("diagnose", "first.parquet", "-o", "first", *few).document()
    assert [effect["name"] for effect in first["joints"][0]["effects"]] == ["stribeck"]
    joint: Any = load_model(tmp_path / "first" / "model.toml").joints[0]
    assert joint.provenance.method == "diagnose"
    assert [term.name for term in joint.terms] == ["coulomb", "viscous", "stribeck"]
    model = ("--joint-model", "first/model.toml")
    assert run("simulate", "joint", "-o", "second.parquet", "--seed", "6", *model, *words).code == 0
    second = run("diagnose", "second.parquet", *model, *few).document()
    assert second["joints"][0]["verdict"] == "adequate"
    (used,) = second["settings"]["diagnosis"]["model"]["joints"]
    assert used["terms"] == [{"name": term.name, "values": pytest.approx(term.values)} for term in joint.terms]
