"""Arms known by name: limits, names of joints, kinds of torque, and what is said where a model is missing."""

import json
import runpy
from math import inf
from pathlib import Path

import pytest

from friction_audit.compensation.settings import limits_of as compensator_limits
from friction_audit.io.readers.channel_names import arm_name, robot_of
from friction_audit.planning import plan
from friction_audit.planning.design import candidates_of
from friction_audit.presets import BUILT_IN, PRESETS, TORQUES, candidates
from friction_audit.robot.arm import read_urdf
from friction_audit.robot.urdf import limits_in
from tests.in_this_process import Run
from tests.io.synthetic_recordings import tidy_frame

URS = ("ur3e", "ur5e", "ur10e", "ur16e", "ur20", "ur30")
UR_NAMES = PRESETS["ur5e"].joints


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_whole(name: str) -> None:
    preset = PRESETS[name]
    joints = len(preset.joints)
    assert len(set(preset.joints)) == joints
    for values in (preset.low_rad, preset.high_rad, preset.speed_rad_s, preset.torque_nm):
        assert len(values) == joints
    assert all(low < high for low, high in zip(preset.low_rad, preset.high_rad, strict=True))
    assert all(0.0 < one < inf for one in (*preset.speed_rad_s, *preset.torque_nm, *preset.acceleration_rad_s2))
    assert len(preset.acceleration_rad_s2) in (0, joints)
    assert preset.torque in TORQUES
    assert preset.source


def test_the_preset_of_the_panda_is_its_built_in_urdf() -> None:
    preset = PRESETS[BUILT_IN]
    for name, *figures in zip(preset.joints, preset.low_rad, preset.high_rad, preset.speed_rad_s, strict=True):
        assert tuple(figures) == limits_in(read_urdf(None), "urdf", name)


@pytest.mark.parametrize(("names", "arms"), [
    (UR_NAMES, URS),
    ([f"left_{name}" for name in UR_NAMES], URS),
    ([f"ur10e_{name}" for name in UR_NAMES], ("ur10e",)),
    (UR_NAMES[:5], ()),
    ([f"lbr_A{k}" for k in range(1, 8)], ("iiwa7", "iiwa14")),
    ([f"iiwa_joint_{k}" for k in range(1, 8)], ("iiwa7", "iiwa14")),
    ([f"iiwa7_joint_{k}" for k in range(1, 8)], ("iiwa7",)),
    ([f"arm/gen3_joint_{k}" for k in range(1, 8)], ("gen3",)),
    ([f"gen3_lite_joint_{k}" for k in range(1, 8)], ()),
    ([f"gen3_joint_{k}" for k in range(1, 7)], ()),
    ([f"xarm7_joint{k}" for k in range(1, 8)], ("xarm7",)),
    ([f"joint{k}" for k in range(1, 8)], ()),
    (["panda_joint4"], ("panda",)),
])  # fmt: skip
def test_arms_by_the_names_of_their_joints(names: list[str], arms: tuple[str, ...]) -> None:
    assert candidates(tuple(names)) == arms
    assert robot_of(names) == (arms[0] if len(arms) == 1 else "unknown")


def test_a_make_is_no_name_of_an_arm() -> None:
    prefixes = ("ur10e", "iiwa_14", "gen3", "left_ur5e", "fr3v2_1")
    assert [arm_name(prefix) for prefix in prefixes] == ["", "", "", "left_ur5e", ""]


def test_limits_of_a_compensator_are_those_of_the_preset() -> None:
    assert (compensator_limits("iiwa14", 5).torque_nm, compensator_limits("panda", 5).torque_nm) == (110.0, 12.0)
    assert compensator_limits("iiwa14", 8).torque_nm == inf


@pytest.mark.thorough
def test_a_plan_without_a_log_is_for_the_arm_named(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "candidates_of", lambda limits: candidates_of(limits)[::9])
    words = ("--robot", "ur5e", "--joints", "3,5", "--drive", "robot", "--no-check", "--duration", "60")
    done = run("plan", *words, "-o", tmp_path)
    assert done.code == 0, done.err
    header = (tmp_path / "trajectory_estimate.csv").read_text().splitlines()[0]
    assert "q_elbow_joint" in header
    text = (tmp_path / "plan.json").read_text()
    assert "Universal_Robots_ROS2_Description" in text
    assert [[one["joint"] for one in each["joints"]] for each in json.loads(text)["recordings"]] == [[3, 5], [3, 5]]


def table(path: Path, torque: str) -> Path:
    fields = {"q": "position", "dq": "velocity", "tau_J": torque}
    columns = {f"{own}_{k}": f"{joint}.{fields[own]}" for own in fields for k, joint in enumerate(UR_NAMES, start=1)}
    tidy_frame(5000, len(UR_NAMES)).rename(columns=columns).to_csv(path, index=False)
    return path


def test_info_names_the_arms_that_share_the_names_and_doubts_the_unit(run: Run, tmp_path: Path) -> None:
    log = table(tmp_path / "ur.csv", "effort")
    done = run("info", log)
    assert "robot unknown (joints of ur3e, ur5e, ur10e, ur16e, ur20, ur30: name it with --robot)" in done.out
    assert "motor current [A]" in done.err
    in_ampere = "tau_J=" + ",".join(f"{name}.effort" for name in UR_NAMES) + ":A"
    for words, robot, unit in (
        (("--robot", "ur10e"), "ur10e", "N m"),
        (("--map", in_ampere), "unknown", "A"),
        (("--torque-scale", "10"), "unknown", "N m"),
    ):
        (entry,) = run("info", log, *words, "--json").document()["logs"]
        doubted = "effort_is_current" in [one["code"] for one in entry["warnings"]]
        assert (entry["robot"], entry["torque_unit"], doubted) == (robot, unit, robot == "ur10e")


def test_a_model_of_a_preset_without_one_is_refused_with_what_to_do(run: Run, tmp_path: Path) -> None:
    log = table(tmp_path / "ur.csv", "torque")
    done = run("estimate", log, "--robot", "ur5e", "--gravity", "model")
    assert done.code == 2
    assert "Universal Robots UR5e: names and limits are known, no rigid-body model" in done.err
    assert "--urdf FILE" in done.err


def test_the_table_of_arms_is_that_of_the_source() -> None:
    docs = Path(__file__).parents[2] / "docs"
    text = (docs / "formats.md").read_text()
    assert runpy.run_path(str(docs / "make_preset_table.py"))["page_of"](text) == text, "run docs/make_preset_table.py"
