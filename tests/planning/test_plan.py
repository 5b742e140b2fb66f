"""``plan``: limits kept by every candidate, designs that separate, and the command end to end."""

import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from friction_audit import robot
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.planning import design, plan as plans
from friction_audit.planning.design import Limits, candidates_of, limits_of
from friction_audit.planning.plan import JointPlan, plan_task, plan_tasks, trajectory_of
from friction_audit.planning.task import Arm, Joint, Task, subject_of, task_of
from friction_audit.preprocessing.interaction import Caution
from friction_audit.reporting.notices import sentence_of
from friction_audit.reporting.plan import Recording, plan_lines
from tests.each_case import thorough
from tests.in_this_process import Run

DURATION = 120
STRIBECK = {"stribeck_excess_nm": 0.15, "stribeck_speed_rad_s": 0.1, "stribeck_exponent": 2.0}


@pytest.fixture(autouse=True, scope="module")
def designed_once() -> Iterator[None]:
    """Take candidates apart once, whatever the duration; plan with every third."""
    known, original = dict[str, design.Information](), design.information_of

    def information_of(*args: Any) -> design.Information:
        key = repr(args)
        if key not in known:
            known[key] = original(*args)
        return known[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design, "information_of", information_of)
        patch.setattr(plans, "candidates_of", lambda limits: candidates_of(limits)[::3])
        yield


def limits(**changes: float) -> Limits:
    usual = {
        "start_rad": 0.3, "low_rad": -0.5, "high_rad": 1.1, "speed_rad_s": 1.5, "acceleration_rad_s2": 2.5,
        "jerk_rad_s3": 100.0, "slowest_rad_s": 0.01,
    }  # fmt: skip
    return Limits(**(usual | changes), source="of this test")


def moved(plan: JointPlan, rate_hz: float) -> list[Float]:
    _, t, *columns = trajectory_of([plan], Arm(("joint1",), (0.0,), "", known_start=True), rate_hz)
    return [t, *(column[:, 0] for column in columns)]


@pytest.mark.parametrize(
    "asked",
    [
        limits(),
        limits(jerk_rad_s3=5.0),
        limits(start_rad=-0.5),
        limits(low_rad=0.25, high_rad=0.35),
        limits(slowest_rad_s=0.05, acceleration_rad_s2=20.0, jerk_rad_s3=1e4),
    ],
)
def test_every_candidate_keeps_the_limits_and_returns_to_the_start(asked: Limits) -> None:
    for one in candidates_of(asked):
        plan = JointPlan(task=Task(joint=Joint()), limits=asked, runs=(one,))
        t, q, dq, ddq = moved(plan, 1000.0)
        assert asked.low_rad - 1e-9 <= q.min(), one.words
        assert q.max() <= asked.high_rad + 1e-9, one.words
        assert np.abs(dq).max() <= asked.speed_rad_s * 1.0001, one.words
        assert np.abs(ddq).max() <= asked.acceleration_rad_s2 * 1.01, one.words
        assert np.abs(np.diff(ddq)).max() * 1000.0 <= asked.jerk_rad_s3 * 1.05, one.words
        assert abs(q[-1] - q[0]) < 1e-9
        assert dq[0] == dq[-1] == 0.0
        assert np.allclose(np.cumsum(dq) / 1000.0, q - q[0], atol=2e-3)
        assert t[-1] == pytest.approx(plan.duration_s, abs=2e-3)


def test_limits_of_the_panda_are_those_published() -> None:
    joint = Joint(number=4, name="panda_joint4", hand=False, reach_rad=(-9.0, 9.0))
    found = limits_of(joint, -2.0, urdf=None, robot="panda")
    assert (found.low_rad, found.high_rad) == pytest.approx((-3.0718 + 0.05, -0.0698 - 0.05))
    assert (found.speed_rad_s, found.acceleration_rad_s2, found.jerk_rad_s3) == (2.175, 3.125, 300.0)
    by_hand = limits_of(replace(joint, hand=True), -2.0, urdf=None, robot="panda")
    assert by_hand.acceleration_rad_s2 == 3.125  # a trajectory for a hand is one for the arm too
    assert by_hand.speed_rad_s == 1.8
    asked = limits_of(joint, -2.0, urdf=None, robot="panda", range_rad=(-0.1, 0.2), speed_rad_s=0.5, jerk_rad_s3=None)
    assert (asked.high_rad, asked.speed_rad_s, asked.jerk_rad_s3) == pytest.approx((-1.8, 0.5, 300.0))
    with pytest.raises(UsageError, match="no joint elbow"):
        limits_of(replace(joint, name="elbow"), 0.0, urdf=Path(robot.__file__).parent / "panda.urdf", robot="")


def test_an_option_replaces_a_limit_that_a_urdf_of_a_cad_program_leaves_at_zero(tmp_path: Path) -> None:
    urdf, limit = tmp_path / "arm.urdf", '<limit lower="-2" upper="2" velocity="0"/>'
    urdf.write_text(f'<robot name="a"><joint name="joint1" type="revolute">{limit}</joint></robot>')
    assert limits_of(Joint(), 0.0, urdf=urdf, speed_rad_s=0.5).speed_rad_s == 0.5
    with pytest.raises(UsageError, match="raise --speed"):
        limits_of(Joint(), 0.0, urdf=urdf)


def test_a_number_that_a_document_leaves_out_takes_no_name_away() -> None:
    numbers = {"curved_viscous_nm": 0.06, "curved_viscous_exponent": 2.4, "curved_viscous_speed_rad_s": None}
    effects = [{"name": "nonlinear_viscous", "alternatives": ["stribeck"], "parameters": numbers}]
    found = {"joint": 1, "name": "joint1", "verdict": "ambiguous", "effects": effects}
    assert task_of(found, True, 0.0).why == "nonlinear_viscous or stribeck"


def test_a_joint_of_many_turns_is_planned_for_within_one() -> None:
    subject = subject_of(Joint())
    far: Any = replace(subject, data=replace(subject.data, q=100.0 * subject.data.q)), None
    found = {"joint": 1, "name": "joint1", "verdict": "not_testable"}
    assert task_of(found, True, 0.0, far).joint.reach_rad == pytest.approx((-2.0 * np.pi, 2.0 * np.pi))


def test_a_recording_for_estimate_determines_both_coefficients() -> None:
    joint = Joint()
    task = Task(joint=joint, purpose="estimate", why="1 cycle: move it")
    plan = plan_task(task, limits(start_rad=-1e-4), 60.0)
    found = plan.coefficients
    true = {"coulomb_nm": joint.parameters.coulomb_nm, "viscous_nms_per_rad": joint.parameters.viscous_nms_per_rad}
    for name, value in true.items():
        assert found[name].value == pytest.approx(value, rel=0.1), name
    shares, other = list[float](), replace(task, joint=replace(joint, number=2))
    both = plan_tasks([(task, plan.limits), (other, plan.limits)], 60.0, check=False, report=shares.append)
    assert [(one.task, one.runs) for one in both] == [(task, plan.runs), (other, plan.runs)]
    assert sorted(shares) == [0.5, 1.0]
    first, second, *_, last, _ = plan_lines([Recording("estimate", (plan,), ())], [])
    assert "(1 cycle): " in first, "the motion is what to do"
    assert second.startswith("start at 0.00 rad")
    assert last.startswith("simulated with Coulomb 0.3 N m, viscous 0.07 N m s/rad, estimate finds")


def result(path: Path, verdict: str, **changes: object) -> Path:
    """Write as much of a document of ``diagnose`` as a plan reads."""
    own = {
        "joint": 2, "name": "panda_joint2", "verdict": verdict, "message": "", "effects": [],
        "gap": {"noise_floor_rms_nm": 0.01},
        "augmented": {"inertia_kg_m2": 0.3, "coulomb_nm": 0.3, "viscous_nms_per_rad": 0.07},
        "from_energy": {"coulomb_nm": 0.3, "viscous_nms_per_rad": 0.07},
    }  # fmt: skip
    source = {"joints": 7, "robot": "panda"}
    document = {
        "schema": "friction-audit/diagnose/3", "source": source, "settings": {"torque_chosen": {"drive": "robot"}},
        "joints": [own | changes],
    }  # fmt: skip
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize("which", [slice(None, None, 3), *thorough([slice(None)])], ids=["every third", "all"])
def test_the_command_separates_checks_and_writes_a_document_and_the_trajectory(
    which: slice, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plans, "candidates_of", lambda limits: candidates_of(limits)[which])
    effect = {"name": "stribeck", "alternatives": ["nonlinear_viscous"], "parameters": STRIBECK}
    source = result(tmp_path / "a.json", "ambiguous", effects=[effect])
    answer = run("plan", source, "--drive", "hand", "--duration", DURATION, "-o", "out", "--json")
    document = answer.document()
    assert answer.code == 0
    (recording,) = document["recordings"]
    assert recording["purpose"] == "decide"
    assert document["warnings"][0]["code"] == "start_unknown"
    assert json.loads((tmp_path / "out/plan.json").read_text()) == document
    (plan,) = recording["joints"]
    assert DURATION - 20.0 < plan["duration_s"] <= DURATION
    assert min(one["two_ln_likelihood_ratio"] for one in plan["separated"]) > 20.0
    assert [one["names"][0] for one in plan["answers"]] == [["stribeck"], ["nonlinear_viscous"]]
    assert [one["decided"] for one in plan["answers"]] == [len(one["names"]) == 1 for one in plan["answers"]]
    assert any("steady" in one["words"] for one in plan["runs"]), "a Stribeck curve takes slow steady motion"
    table = np.genfromtxt(tmp_path / "out/trajectory.csv", delimiter=",", names=True)
    assert all(low < high for low, high in pairwise(table["time_s"]))
    assert np.ptp(table["q_panda_joint1"]) == 0.0 < np.ptp(table["q_panda_joint2"])
    with (tmp_path / "out/trajectory.mcap").open("rb") as file:
        ((_, _, _, message),) = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
    assert list(message.joint_names) == [f"panda_joint{k}" for k in range(1, 8)]
    assert message.points[100].positions[1] == pytest.approx(table["q_panda_joint2"][100], abs=1e-8)
    assert run("plan", source, "--no-check", "-o", "out").code == 2  # files that exist


def test_a_joint_at_rest_is_planned_for_only_by_its_number(run: Run, tmp_path: Path) -> None:
    document = json.loads(result(tmp_path / "diagnose.json", "adequate").read_text())
    (moved,) = document["joints"]
    still = sentence_of(Caution("did_not_move", numbers={"initiation": 0.2, "unit": "rad/s"}))
    at_rest = [moved | {"joint": k, "verdict": "not_testable", "message": f"0 cycles: {still}"} for k in (1, 3)]
    (tmp_path / "diagnose.json").write_text(json.dumps(document | {"joints": [at_rest[0], moved, at_rest[1]]}))
    text = run("plan", tmp_path, "--duration", "60").out
    assert "joints 1, 3: did not move; for a recording of one: --joints 1\n" in text
    assert "joint 2: no motion planned: adequate\n" in text
    assert "joint 2, to diagnose" in text, "the joint that moved"
    assert "diagnose would answer" not in text, "a diagnosis of each effect of the catalogue takes half a minute"
    asked = run("plan", tmp_path / "diagnose.json", "--no-check", "--joints", "3", "--json").document()
    (recording,) = asked["recordings"]
    assert [(one["joint"], one["why"]) for one in recording["joints"]] == [(3, "did not move")]


@pytest.mark.thorough
def test_a_result_without_open_names_says_so_and_offers_the_best_recording(run: Run, tmp_path: Path) -> None:
    document = json.loads(result(tmp_path / "a.json", "adequate").read_text())
    constants = {"name": "torque_bias", "alternatives": ["asymmetric_coulomb"], "parameters": {"torque_bias_nm": 0.1}}
    (adequate,) = document["joints"]
    other = {"joint": 3, "name": "panda_joint3", "verdict": "ambiguous", "effects": [constants]}
    (tmp_path / "a.json").write_text(json.dumps(document | {"joints": [adequate, adequate | other]}))
    text = run("plan", tmp_path / "a.json", "--no-check", "--duration", "60").out
    assert "joint 2: no motion planned: adequate" in text
    assert "to diagnose" in text
    assert "to estimate friction" in text
    assert "no motion of the joint separates torque_bias from asymmetric_coulomb" in text
    short = run("plan", tmp_path / "a.json", "--no-check", "--duration", "5")
    assert (short.code, "longer --duration" in short.err) == (4, True)


def test_what_it_refuses(run: Run, tmp_path: Path) -> None:
    source = result(tmp_path / "a.json", "adequate")
    (tmp_path / "other.json").write_text('{"schema": "friction-audit/diff/1"}')
    (tmp_path / "half.json").write_text('{"schema": "friction-audit/diagnose/3"}')
    (tmp_path / "empty.csv").touch()
    assert [run("plan", tmp_path / name).code for name in ("other.json", "half.json", "empty.csv")] == [3, 3, 3]
    for words in (("--speed", "0.001"), ("--range=0.5,0.6",), ("--start", "1,2"), ("--acceleration", "1e-5")):
        answer = run("plan", source, "--no-check", *words)
        assert answer.code == 2, words
        assert "expected" in answer.err or "give" in answer.err


@pytest.mark.thorough
def test_a_drift_is_looked_for_at_both_ends_of_the_time() -> None:
    numbers = {"drift_1_nm": 0.15, "drift_2_nm": 0.0, "drift_3_nm": 0.0, "drift_4_nm": 0.0, "drift_waves": 1.0}
    effects = [{"name": "torque_drift", "alternatives": ("asymmetric_coulomb", "torque_bias"), "parameters": numbers}]
    found = {"joint": 1, "name": "joint1", "verdict": "ambiguous", "effects": effects}
    plan = plan_task(task_of(found, True, 0.0), limits(slowest_rad_s=0.05), 120.0)
    assert plan.duration_s == pytest.approx(120.0)
    assert sum(run.duration_s for run in plan.runs) < 0.15 * 120.0
    t, _, dq, _ = moved(plan, 100.0)
    going = t[np.abs(dq) > 0.0]
    gap = int(np.argmax(np.diff(going)))
    assert going[gap] < 20.0
    assert going[gap + 1] > 100.0
    assert going[gap + 1] - going[gap] == pytest.approx(plan.rest_s, abs=1.0)
    displacements = [one.displacement_rad for one in plan.motion.strokes]
    assert displacements[: len(displacements) // 2] == displacements[len(displacements) // 2 :]
    assert all(one.decided for one in plan.answers), plan.answers
    short = plan_task(plan.task, plan.limits, 45.0, check=False)  # no time for both ends
    assert (short.rest_s, len(short.runs) >= 3) == (0.0, True)
    text = plan_lines([Recording("decide", (plan,), ())], [])
    assert any("s, and all of it once more" in line for line in text)
