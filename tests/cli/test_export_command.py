"""``export`` and ``--export``: from a log, an estimate and a model to files, and what is refused."""

import json
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import pandas as pd
import pytest
from mcap.reader import make_reader

from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, save_model
from friction_audit.reporting.diagnosis import DIAGNOSE
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.replay import REPLAY
from tests.in_this_process import Run

TERMS = {"coulomb": (0.4,), "stribeck": (0.2, 0.1, 1.0), "torque_bias": (0.1,)}
JOINT = JointModel(inertia_kg_m2=0.3, terms=tuple(FittedTerm(*term) for term in TERMS.items()))
MODEL = ArmModel(names=("joint1", "joint2"), joints=(JOINT, None))


def test_a_log_and_its_estimate_give_the_same_file(run: Run, tmp_path: Path) -> None:
    assert run("simulate", "joint", "-o", "run.parquet", "--duration", "30", "-q").code == 0
    document = run("export", "run.parquet", "log.xml", "--json").document()
    (joint,), (gap,) = document["joints"], document["simulated"]
    assert joint["inertia_kg_m2"] == pytest.approx(0.3, rel=0.02)  # a person drives: it is that of the motor
    assert gap["with_rad"] < 0.1 * gap["without_rad"]
    frame = pd.read_parquet("run.parquet")
    frame.loc[len(frame) // 2 :, "time"] += 3e7  # a second part, a year later
    frame.to_parquet("parts.parquet")
    (gap,) = run("export", "parts.parquet", "parts.xml", "--json").document()["simulated"]
    assert gap["with_rad"] < 0.1 * gap["without_rad"]
    assert run("estimate", "run.parquet", "-o", "results", "--figures", "velocity-torque", "-q").code == 0
    for source, out in (("results", "folder.xml"), ("results/estimate.json", "document.xml")):
        assert run("export", source, out).code == 0
        assert (tmp_path / out).read_bytes() == (tmp_path / "log.xml").read_bytes()


def test_numbers_have_the_intervals_of_the_source_and_one_that_it_does_not_resolve_is_said_to_be_zero(run: Run) -> None:
    def one(joint: int, coulomb: object, viscous: object) -> dict[str, object]:
        found = {"coulomb_nm": coulomb, "viscous_nms_per_rad": viscous, "regression": None, "reason": None}
        return {"joint": joint, "name": f"j{joint}", **found}

    sure = {"value": 0.2, "ci95": [0.19, 0.21]}
    joints = [one(1, sure, None), one(2, sure, {"value": -0.01, "ci95": [-0.03, 0.01]})]
    chosen = {"torque_chosen": {"drive": "hand", "inertia": "none"}}
    document = {"schema": "friction-audit/estimate/1", "source": {}, "settings": chosen, "joints": joints}
    Path("estimate.json").write_text(json.dumps(document))
    answer = run("export", "estimate.json", "out.urdf")
    rows = [line.split(maxsplit=2)[2] for line in answer.out.splitlines() if line.startswith(("1", "2"))]
    assert [" ".join(row.split()) for row in rows] == ["0.200 ± 0.010 0", "0.195 0"]
    assert "intervals are 95 %" in answer.out
    assert "joint 1: the file has no viscous friction: the source does not determine it" in answer.err
    # Over 0.01 to 1 rad/s the best constant is the law's mean, 0.2 - 0.01 * 0.505.
    assert "joint 2: the file has no viscous friction: it is -0.010 ± 0.020 N m s/rad; the friction" in answer.err
    assert ET.parse("out.urdf").findall(".//dynamics")[1].get("friction") == "0.19495"


def test_a_model_file_says_what_no_simulator_holds(run: Run, tmp_path: Path) -> None:
    save_model(MODEL, tmp_path / "model.toml")
    document = run("export", "model.toml", "out.urdf", "--speeds", "0,2", "--json").document()
    assert [joint["joint"] for joint in document["joints"]] == [1]
    codes = {warning["code"]: warning["message"] for warning in document["warnings"]}
    assert set(codes) == {"no_friction", "terms_left_out", "friction_fitted"}
    assert "torque_bias" in codes["terms_left_out"]
    assert "armature_left_out" in run("export", "model.toml", "out.py", "--json").out
    armature = run("export", "model.toml", "with.py", "--armature", "--json").document()
    assert armature["joints"][0]["inertia_kg_m2"] == 0.3


def test_the_user_s_file_and_older_ones_stay(run: Run, tmp_path: Path) -> None:
    save_model(MODEL, tmp_path / "model.toml")
    arm = '<mujoco><worldbody><body><joint name="joint1"/><geom size="1"/></body></worldbody></mujoco>'
    (tmp_path / "arm.xml").write_text(arm)
    for out in ("arm.xml", "model.toml"):
        assert run("export", "model.toml", out, "--into", "arm.xml", "--overwrite").code == 2
    assert run("export", "model.toml", "out.xml", "--into", "arm.xml", "--joints", "1").code == 0
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "out.xml")).dof_frictionloss[0] > 0.4
    before = (tmp_path / "out.xml").read_bytes()
    assert run("export", "model.toml", "out.xml").code == 2
    assert (tmp_path / "out.xml").read_bytes() == before
    assert (tmp_path / "arm.xml").read_text() == arm


@pytest.mark.usefixtures("here")
def test_the_reference_of_a_batch_is_exported(run: Run) -> None:
    for seed in range(5):
        words = ("--duration", 20, "--rate", 200, "--seed", seed, "-o", f"arm/{seed}.parquet", "-q")
        assert run("simulate", "joint", *words).code == 0
    assert run("batch-report", "arm", "-o", "drift", "-q").code == 0
    batch = json.loads(Path("drift/batch.json").read_text())
    levels = [one["coefficients"]["coulomb_nm"]["level"]["value"] for one in batch["joints"]]
    for source, out in (("drift", "a.csv"), ("drift/batch.json", "b.csv"), ("drift/ledger.sqlite", "c.csv")):
        document = run("export", source, out, "--json").document()
        assert [joint["coulomb_nm"] for joint in document["joints"]] == pytest.approx(levels)
        assert document["joints"][0]["coulomb_nm"] == pytest.approx(0.3, abs=0.03)
        assert document["joints"][0]["inertia_kg_m2"] is None
        assert Path(out).read_text() == Path("a.csv").read_text()


def test_of_several_arms_of_a_batch_one_is_named(run: Run) -> None:
    levels = {"a": 0.3, "b": 0.4}
    joints = [
        {"robot": robot, "joint": 1, "name": "j1", "coefficients": {"coulomb_nm": {"level": {"value": level}}}}
        for robot, level in levels.items()
    ]
    document = {"schema": "friction-audit/batch/2", "robots": [{"robot": robot} for robot in levels], "joints": joints}
    Path("batch.json").write_text(json.dumps(document))
    answer = run("export", "batch.json", "out.csv")
    assert (answer.code, answer.err) == (2, "error: batch.json: 2 arms; it holds a, b; choose one with --arm\n")
    assert "no arm c; it holds a, b" in run("export", "batch.json", "out.csv", "--arm", "c").err
    chosen = run("export", "batch.json", "out.csv", "--arm", "b", "--json").document()["joints"]
    assert [joint["coulomb_nm"] for joint in chosen] == [pytest.approx(0.4)]
    del document["robots"]
    Path("batch.json").write_text(json.dumps(document))
    assert "is no whole document of `batch-report`" in run("export", "batch.json", "more.csv").err
    save_model(MODEL, Path("model.toml"))
    assert "holds one arm; leave the option out" in run("export", "model.toml", "more.csv", "--arm", "b").err
    assert not Path("more.csv").exists()


RESULTS = {"estimate": ESTIMATE, "replay": REPLAY, "diagnose": DIAGNOSE}
TABLES = {command: [table.name for table, _ in result.files] for command, result in RESULTS.items()}
TABLES["report"] = [name for names in TABLES.values() for name in names]


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("command", TABLES)
def test_every_table_is_written(command: str, run: Run, logs: Path) -> None:
    beside: tuple[str, ...] = ("--format", "markdown") if command == "report" else ("--figure-format", "svg")
    beside += ("--candidates", "stribeck") if command == "diagnose" else ()
    answer = run(command, logs / "moved1.csv", "-o", "out", *beside, "--export", "csv,parquet,mcap", "-q")
    assert answer.code == 0, answer.err
    before = "moved1.report." if command == "report" else ""
    for name in TABLES[command]:
        csv = pd.read_csv(f"out/{before}{name}.csv")
        assert list(csv.columns) == list(pd.read_parquet(f"out/{before}{name}.parquet").columns)
    with Path(f"out/{before or f'{command}.'}mcap").open("rb") as stream:
        summary: Any = make_reader(stream).get_summary()
    topics = {channel.topic.rpartition("/")[2] for channel in summary.channels.values()}
    filled = {name for name in TABLES[command] if len(pd.read_csv(f"out/{before}{name}.csv"))}
    assert topics == filled


def test_a_table_that_exists_and_the_log_itself_are_kept(run: Run, logs: Path) -> None:
    log, mine = Path("out/interaction.csv"), Path("out/cycles.csv")
    log.parent.mkdir()
    shutil.copy(logs / "moved1.csv", log)
    mine.write_text("mine")
    words = ("-o", "out", "--export", "csv")
    answer = run("estimate", logs / "moved1.csv", *words)
    assert (answer.code, "out/cycles.csv, out/interaction.csv: exists already" in answer.err) == (2, True), answer
    answer = run("estimate", log, *words, "--overwrite")
    assert (answer.code, "interaction.csv: is the log itself; nothing was written" in answer.err) == (2, True), answer
    assert (mine.read_text(), log.read_bytes()) == ("mine", (logs / "moved1.csv").read_bytes())
    assert {*Path("out").iterdir()} == {log, mine}
