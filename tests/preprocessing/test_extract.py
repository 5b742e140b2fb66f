"""The table of the balance, one row and one source at a time."""

import re
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.errors import UsageError
from friction_audit.joint_log import Finding, Float, JointLog, Source
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.interaction_torque import extract_interaction
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.robot import load_arm

COULOMB = np.array([0.3, 0.25, 0.3, 0.4, 0.3, 0.2, 0.25])
DEAD_2 = Finding(code="torque_dead", message="", joint=2)
PENDULUM = """<robot name="pendulum"><link name="base"/>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint>
  <link name="bob"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link></robot>"""


def motion(joints: int, seconds: float = 12.0) -> tuple[Float, Float, Float, Float]:
    t = np.arange(0.0, seconds, 0.001)
    omega = 2 * np.pi * np.linspace(0.4, 0.9, joints)
    phase = t[:, None] * omega
    centre = np.array([0.0, -0.8, 0.0, -2.3, 0.0, 1.5, 0.8])[:joints]
    swing = 1.2 / omega
    return t, centre - swing * np.cos(phase), 1.2 * np.sin(phase), 1.2 * omega * np.cos(phase)


def log_of(robot: str = "panda", joints: int = 7, **channels: Any) -> JointLog:
    t, q, dq, _ = motion(joints)
    source = Source(path="made.csv", sha256="", format="csv", robot=robot)
    names = tuple(f"panda_joint{number}" for number in range(1, joints + 1))
    return JointLog(t=t, q=q, dq=dq, joint_names=names, source=source, **channels)


def friction(joints: int = 7) -> Float:
    _, _, dq, _ = motion(joints)
    noise = np.random.default_rng(2).normal(0, 0.05, dq.shape)
    return np.asarray(COULOMB[:joints] * np.sign(dq) + noise)


def hand_log(robot: str = "panda", **channels: Any) -> JointLog:
    """A person moves the arm: tau_J = gravity - F_m."""
    _, q, _, _ = motion(7)
    return log_of(robot, tau_J=load_arm().gravity(q) - friction(), **channels)


def robot_log(robot: str = "panda", **channels: Any) -> JointLog:
    """The arm moves by itself: tau_J = M ddq + c + g + F_m."""
    _, q, dq, ddq = motion(7)
    return log_of(robot, tau_J=load_arm().inverse_dynamics(q, dq, ddq) + friction(), **channels)


def extract(log: JointLog, joints: tuple[int, ...] | None = None, *, hand: bool = False, **choices: Any) -> Interaction:
    return extract_interaction(log, TorqueSettings(**choices), joints=joints, hand=hand)


def tau_J_of(log: JointLog) -> Float:
    assert log.tau_J is not None
    return log.tau_J


def codes(interaction: Interaction) -> list[str]:
    return [caution.code for caution in interaction.warnings]


def test_hand_row_is_gravity_minus_tau_J() -> None:
    found = extract(hand_log())
    np.testing.assert_allclose(found.torque, friction(), atol=0.01)
    choice = found.choice
    assert (choice.source, choice.gravity, choice.inertia, choice.drive) == ("tau_J", "model", "none", "hand")
    assert (choice.sign, choice.sign_proved, choice.sign_turned, choice.robot) == (-1, True, False, "panda")
    assert choice.formula == "F_m = g - tau_J"
    assert [one.verdict for one in choice.sign_evidence] == ["rises"] * 7
    assert codes(found) == []


def test_an_arm_that_moves_by_itself_is_noticed() -> None:
    found = extract(robot_log())
    choice = found.choice
    assert (choice.drive, choice.inertia, choice.sign, choice.sign_turned) == ("robot", "model", 1, True)
    assert choice.formula == "F_m = tau_J - (M ddq + c + g)"
    assert codes(found) == ["sign_turned"]
    inside = slice(500, -500)
    error = (found.torque - friction())[inside]
    assert np.sqrt((error**2).mean(axis=0)).max() < 0.02


def test_the_user_s_drive_is_kept_even_if_the_energy_contradicts_it() -> None:
    found = extract(robot_log(), drive="hand")
    assert (found.choice.drive, found.choice.sign_proved, found.choice.sign_turned) == ("hand", False, False)
    assert codes(found) == ["sign_contradicts_drive"]
    (caution,) = found.warnings
    assert "--drive hand is kept as asked; perhaps the other --drive is meant" in caution.message
    assert "tau_compensation" not in caution.message


def test_a_compensator_of_the_wrong_sign_is_suspected_where_no_row_and_no_sign_rises() -> None:
    compensation = 1.5 * COULOMB * np.sign(motion(7)[2])
    wrong = log_of("unknown", tau_interaction=friction() - compensation, tau_compensation=-compensation)
    (caution,) = extract(wrong, drive="hand").warnings
    assert caution.code == "sign_contradicts_drive"
    assert "nor does it rise with the sign turned; perhaps tau_compensation has the wrong sign" in caution.message
    assert "--drive" not in caution.message
    assert "asked" not in caution.message


def test_a_row_that_the_inertia_implies_is_called_so() -> None:
    (caution,) = extract(hand_log(), inertia="model").warnings
    assert caution.code == "sign_contradicts_drive"
    assert "--inertia model (the robot moves the arm) is kept as asked" in caution.message


def test_logged_gravity_comes_before_the_model() -> None:
    _, q, _, _ = motion(7)
    log = hand_log(gravity=load_arm().gravity(q))
    found = extract(log)
    assert (found.choice.gravity, found.choice.robot, found.choice.model_rate_hz) == ("logged", "none", None)
    np.testing.assert_allclose(found.torque, friction(), atol=1e-12)


def test_logged_gravity_with_modelled_inertia() -> None:
    _, q, _, _ = motion(7)
    found = extract(robot_log(gravity=load_arm().gravity(q)), drive="robot")
    assert (found.choice.gravity, found.choice.inertia, found.choice.robot) == ("logged", "model", "panda")
    assert np.sqrt(((found.torque - friction())[500:-500] ** 2).mean(axis=0)).max() < 0.02


@pytest.mark.parametrize(("drive", "sign"), [("hand", -1), ("robot", 1)])
def test_tau_ext_takes_the_sign_of_its_row(drive: str, sign: int) -> None:
    log = log_of("unknown", tau_ext_hat_filtered=sign * friction())
    found = extract(log)
    assert (found.choice.source, found.choice.gravity, found.choice.drive) == ("tau_ext", "absent", drive)
    np.testing.assert_array_equal(found.torque, friction())
    assert codes(found) == ["tau_ext_filtered"] + ["sign_turned"] * (drive == "robot")


def test_an_interaction_torque_is_taken_as_it_is_or_turned() -> None:
    as_is, turned = (extract(log_of("unknown", tau_interaction=sign * friction())) for sign in (1, -1))
    np.testing.assert_array_equal(as_is.torque, turned.torque)
    assert (as_is.choice.sign, turned.choice.sign) == (1, -1)
    assert (codes(as_is), codes(turned)) == ([], ["sign_turned"])
    assert (as_is.choice.formula, turned.choice.formula) == ("F_m = tau_interaction", "F_m = -tau_interaction")


def test_auto_takes_tau_J_with_a_known_model_before_the_filtered_estimate() -> None:
    assert extract(hand_log(tau_ext_hat_filtered=-friction())).choice.source == "tau_J"


def test_auto_trusts_the_vendor_s_estimate_if_a_payload_is_missing_from_the_model() -> None:
    _, q, _, _ = motion(7)
    gravity = load_arm(payload=(0.73, -0.01, 0.0, 0.03)).gravity(q)
    log = log_of("panda", tau_J=gravity - friction(), tau_ext_hat_filtered=-friction())
    found = extract(log)
    assert found.choice.source == "tau_ext"
    assert codes(found) == ["tau_ext_filtered", "payload_missing"]
    with_hand = extract(log, payload=(0.73, -0.01, 0.0, 0.03))
    assert (with_hand.choice.source, with_hand.choice.payload) == ("tau_J", (0.73, -0.01, 0.0, 0.03))
    np.testing.assert_allclose(with_hand.torque, friction(), atol=0.01)


def test_an_unknown_arm_keeps_its_gravity_and_says_what_to_do() -> None:
    found = extract(hand_log("unknown"))
    assert found.choice.formula == "F_m = -tau_J, gravity still inside"
    assert (found.choice.gravity, found.choice.gravity_in_torque) == ("none", True)
    assert "gravity_in_torque" in codes(found)


def test_an_fr3_does_not_get_a_panda_s_inertias_unasked() -> None:
    found = extract(hand_log("fr3"))
    assert found.choice.gravity == "none"
    assert codes(found)[:2] == ["fr3_no_model", "gravity_in_torque"]
    with pytest.raises(UsageError, match="FR3"):
        extract(hand_log("fr3"), gravity="model")
    assert extract(hand_log("fr3"), gravity="model", robot="panda").choice.robot == "panda"


def test_no_robot_is_assumed_of_a_log_that_names_none() -> None:
    found = extract(robot_log("unknown"), drive="robot")
    assert (found.choice.robot, found.choice.gravity, found.choice.inertia) == ("none", "none", "none")
    (caution,) = [one for one in found.warnings if one.code == "gravity_in_torque"]
    assert "`friction-audit estimate made.csv --drive robot --robot panda`" in caution.message
    assert "`friction-audit estimate made.csv --drive robot --map tau_interaction=COLUMN`" in caution.message
    named = extract(robot_log("unknown"), drive="robot", robot="panda")
    assert (named.choice.robot, named.choice.gravity, named.choice.inertia) == ("panda", "model", "model")
    by_itself = next(one for one in extract(robot_log("unknown")).warnings if one.code == "sign_turned")
    assert "`friction-audit estimate made.csv --drive robot --robot none`" in by_itself.message


@pytest.mark.parametrize(
    ("choices", "option"), [({"gravity": "model"}, "--gravity"), ({"inertia": "model"}, "--inertia")]
)
def test_a_model_of_an_arm_without_a_name_is_refused_with_the_commands(choices: dict[str, Any], option: str) -> None:
    with pytest.raises(UsageError) as refused:
        extract(robot_log("unknown"), **choices)
    assert f"`friction-audit estimate made.csv {option} model --robot panda`" in str(refused.value)
    assert "without a model: `friction-audit estimate made.csv --robot none`" in str(refused.value)
    with pytest.raises(UsageError, match="--cycles-from hand"):
        extract(hand_log("unknown"), hand=True)


@pytest.mark.parametrize("drive", ["hand", "robot"])
def test_a_model_further_from_the_torque_than_none_is_refused_with_the_numbers(drive: str) -> None:
    """Torques of another arm, a few newton metres, and a torque from which gravity is removed already."""
    q = motion(7)[1]
    other = log_of("unknown", tau_J=2.0 * np.cos(q) + friction())
    with pytest.raises(UsageError) as refused:
        extract(other, robot="panda", drive=drive)
    assert f"friction-audit estimate made.csv --drive {drive} --robot none" in str(refused.value)
    assert len(re.findall(r"\d+\.\d\d", str(refused.value))) == 14
    with pytest.raises(UsageError, match=r"already removed from tau_J: .*--map tau_interaction=COLUMN"):
        extract(log_of("panda", tau_J=friction()), drive=drive)
    dead = replace(robot_log(), source=replace(robot_log().source, findings=(DEAD_2,)))
    torque = tau_J_of(dead).copy()
    torque[:, 1] = 0.0
    assert extract(replace(dead, tau_J=torque), drive=drive).choice.robot == "panda"


@pytest.mark.parametrize(
    "wrong",
    [{"payload": (3.0, 0.0, 0.0, 0.1)}, {"gravity_vector": (2.5, 0.0, -9.5)}, {"gravity_vector": (0.0, 2.5, -9.5)}],
)
@pytest.mark.parametrize("log", [hand_log(), robot_log()], ids=["hand", "robot"])
def test_a_wrong_payload_or_a_base_that_leans_is_no_other_arm(log: JointLog, wrong: dict[str, Any]) -> None:
    assert extract(log, **wrong).choice.robot == "panda"


def test_a_current_gets_no_gravity_of_a_model() -> None:
    log = robot_log()
    current = replace(log, source=replace(log.source, torque_unit="A"))
    found = extract(current, drive="robot")
    assert (found.choice.gravity, found.choice.robot) == ("none", "none")
    with pytest.raises(UsageError, match="is a motor current"):
        extract(current, gravity="model")


@pytest.mark.parametrize(("robot", "joints"), [("unknown", 1), ("panda", 1), ("panda", 6)])
def test_a_model_that_nobody_demanded_is_done_without_where_the_log_has_other_joints(robot: str, joints: int) -> None:
    log = log_of(robot, joints, tau_J=5.0 + friction(joints), gravity=np.full((12_000, joints), 5.0))
    found = extract(log, drive="robot")
    np.testing.assert_allclose(found.torque, friction(joints), atol=1e-12)
    assert (found.choice.gravity, found.choice.inertia) == ("logged", "none")
    # A joint alone has its kinetic energy back at the end of every cycle.
    assert codes(found) == (["inertia_in_torque"] if joints > 1 else [])


PAYLOAD = (0.73, -0.01, 0.0, 0.03)
TILTED = (9.81, 0.0, 0.0)
LEANING = (1.0, 0.0, -9.76)


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    path = tmp_path / "panda.urdf"
    path.write_bytes(resources.files("friction_audit.robot").joinpath("panda.urdf").read_bytes())
    return path


def test_what_is_said_about_the_arm_and_not_used_is_named(urdf: Path) -> None:
    log = log_of("unknown", tau_interaction=friction())
    (caution,) = extract(log, payload=PAYLOAD, urdf=urdf, gravity_vector=TILTED).warnings
    assert caution.code == "model_not_used"
    assert caution.message.startswith("--payload, --urdf, --gravity-vector: not used: F_m = tau_interaction needs no")
    (caution,) = extract(log, urdf=urdf, payload=PAYLOAD, hand=True).warnings
    assert caution.message.startswith("--payload: not used")  # the speed of the hand comes from the URDF


def test_what_is_used_is_not_named(urdf: Path) -> None:
    assert "model_not_used" not in codes(extract(hand_log(), payload=PAYLOAD, gravity_vector=LEANING))
    assert "model_not_used" not in codes(extract(hand_log("unknown"), urdf=urdf))
    beside = hand_log(gravity=load_arm().gravity(motion(7)[1]))
    assert codes(extract(beside, urdf=urdf)) == []  # the direction of gravity is the model's
    (caution,) = extract(beside, payload=PAYLOAD).warnings
    assert caution.message.endswith("leave it away, or ask for the model with --torque tau_J --gravity model")


def test_a_file_that_is_no_arm_is_refused_even_where_none_is_needed(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    log = log_of("unknown", tau_interaction=friction())
    with pytest.raises(UsageError, match="No such file"):
        extract(log, urdf=path)
    path.write_text("<robot/>")
    with pytest.raises(UsageError, match="no revolute joint"):
        extract(log, urdf=path)


@pytest.mark.parametrize("choices", [{"gravity": "model"}, {"inertia": "model"}])
def test_an_unknown_arm_of_another_size_needs_its_urdf(choices: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match=r"joints: 2\).*`friction-audit estimate made\.csv .*--urdf FILE`"):
        extract(log_of("unknown", 2, tau_J=friction(2)), **choices)


def test_any_arm_by_its_urdf(tmp_path: Any) -> None:
    path = tmp_path / "pendulum.urdf"
    path.write_text(PENDULUM)
    _, q, _, ddq = motion(1)
    log = log_of("unknown", 1, tau_J=0.5 * ddq + 9.81 * np.sin(q) + friction(1))
    found = extract(log, urdf=path, drive="robot")
    assert (found.choice.robot, found.choice.inertia) == ("pendulum", "model")
    assert np.sqrt(np.mean((found.torque - friction(1))[500:-500] ** 2)) < 0.01


def test_a_compensator_s_torque_is_added_up_and_counts_in_the_proof() -> None:
    _, _, dq, _ = motion(7)
    compensation, passivity = 1.5 * COULOMB * np.sign(dq), -0.1 * np.sign(dq)
    log = hand_log(tau_compensation=compensation, tau_passivity=passivity)
    # Overcompensated: the hand's torque is against the motion, and only the sum of both is what friction takes.
    over = replace(log, tau_J=tau_J_of(log) + compensation + passivity)
    found = extract(over)
    assert found.compensation is not None
    np.testing.assert_allclose(found.compensation, compensation + passivity)
    assert (found.choice.drive, found.choice.sign_proved) == ("hand", True)
    assert extract(replace(log, tau_compensation=None)).compensation is not None
    assert extract(hand_log()).compensation is None


def test_selected_joints_are_the_same_as_among_all() -> None:
    log = hand_log()
    whole, some = extract(log), extract(log, joints=(5, 2))
    assert (some.joint_numbers, some.joint_names) == ((2, 5), ("panda_joint2", "panda_joint5"))
    np.testing.assert_allclose(some.torque, whole.torque[:, [1, 4]], atol=1e-12)
    np.testing.assert_array_equal(some.q, log.q[:, [1, 4]])
    assert some.choice == whole.choice


def test_unknown_joints_are_named_with_those_there_are() -> None:
    with pytest.raises(UsageError, match=r"--joints 0,9: not in made\.csv; its joints are 1 \(panda_joint1\), 2"):
        extract(hand_log(), joints=(0, 3, 9))


def test_a_joint_that_disagrees_is_named() -> None:
    log = hand_log()
    wrong = tau_J_of(log).copy()
    wrong[:, 2] += 2 * friction()[:, 2]
    found = extract(replace(log, tau_J=wrong))
    assert found.choice.sign_proved
    assert [(one.code, one.joint) for one in found.warnings] == [("sign_disagrees", 3)]


@pytest.mark.parametrize("dead", [frozenset({1, 2, 3, 4}), frozenset()])
def test_joints_without_a_torque_cast_no_vote(dead: frozenset[int]) -> None:
    """Four joints whose torque is a few counts that go with the motion, three that are right."""
    log = hand_log()
    torque = tau_J_of(log).copy()
    torque[:, :4] = 0.001 * np.round(2.0 * np.tanh(log.dq[:, :4]))
    findings = tuple(Finding(code="torque_dead", message="", joint=joint) for joint in dead)
    source = replace(log.source, findings=findings)
    found = extract(
        replace(log, tau_J=None, tau_interaction=np.where(np.arange(7) < 4, -torque, friction()), source=source)
    )
    assert (found.choice.sign, found.choice.sign_proved) == (1, bool(dead))
    assert [one.code for one in found.warnings] == ([] if dead else ["sign_unproved"])


def test_a_bus_that_updates_a_joint_every_seventh_row_has_its_sign_proved() -> None:
    """Rows at rest are kept, rows that repeat in motion were left out: the steps in motion are 70 ms of a 10 ms log."""
    t = np.arange(0.0, 60.0, 0.01)
    dq = np.where(t % 5.0 < 2.5, 0.8 * np.sin(2 * np.pi * t / 2.5) * np.sign(np.sin(np.pi * t / 5.0 + 0.1)), 0.0)
    fresh = (dq == 0.0) | (np.arange(len(t)) % 7 == 0)
    q = np.cumsum(dq) * 0.01
    noise = 0.01 * np.random.default_rng(3).normal(size=len(t))
    torque = 0.116 * np.sign(dq) + 0.04 * dq + noise
    channels = {name: values[fresh][:, None] for name, values in (("q", q), ("dq", dq), ("tau_J", torque))}
    source = Source(path="made.csv", sha256="", format="csv")
    log = JointLog(t=t[fresh] - t[fresh][0], joint_names=("joint5",), source=source, **channels)
    choice = extract(log).choice
    assert (choice.drive, choice.sign_proved, choice.sign_turned) == ("robot", True, True)


FORGOTTEN = load_arm(payload=(2.0, 0.05, 0.0, 0.1))


@pytest.mark.parametrize(
    ("forgotten", "short", "said"), [(True, False, "payload"), (False, False, ""), (True, True, "no payload")]
)
def test_gravity_that_is_left_is_said_as_rms_where_it_can_be_told(forgotten: bool, short: bool, said: str) -> None:
    _, q, dq, _ = motion(7)
    swing = 0.02 if short else 1.0
    centre = q.mean(axis=0)
    q, dq = centre + swing * (q - centre), swing * dq
    t, arm = motion(7)[0], FORGOTTEN if forgotten else load_arm()
    torque = arm.gravity(q) - friction()
    log = replace(log_of("panda", tau_J=torque), q=q, dq=dq, t=t)
    found = {one.joint or 0: one for one in extract(log, drive="hand").warnings if one.code in LEFT}
    if not said:
        assert not found
        return
    truth = np.sqrt(np.mean((arm.gravity(q) - load_arm().gravity(q)) ** 2, axis=0))
    assert 4 in found
    assert 1 not in found  # its axis is vertical
    for joint, caution in found.items():
        size = float(re.findall(r"(-?\d+\.\d) N m", caution.message)[0])
        # Where other joints move too, only a part goes with the joint's own posture: a lower bound.
        if caution.code == "gravity_error" or short:
            assert (0.9 if short else 0.3) * truth[joint - 1] < abs(size) < 1.15 * truth[joint - 1]
        assert ("a payload is probably missing" in caution.message) == (caution.code == "gravity_error")
    by_position = [one for one in found.values() if one.code == "gravity_error"]
    assert len(by_position) >= 1 if said == "payload" else not by_position


LEFT = ("gravity_error", "torque_offset")


def test_gravity_that_is_declared_to_be_inside_is_no_error_nor_is_a_current() -> None:
    _, q, dq, ddq = motion(7)
    log = log_of("unknown", tau_J=FORGOTTEN.inverse_dynamics(q, dq, ddq) + friction())
    assert not set(LEFT) & set(codes(extract(log, drive="robot")))
    pulled = log_of("unknown", tau_interaction=friction() + 4.0 * np.sin(q))
    assert "gravity_error" in codes(extract(pulled))
    assert not set(LEFT) & set(codes(extract(replace(pulled, source=replace(pulled.source, torque_unit="A")))))


def test_nothing_moves_nothing_is_proved() -> None:
    log = hand_log()
    found = extract(replace(log, dq=np.zeros_like(log.dq), q=np.zeros_like(log.q)))
    assert not found.choice.sign_proved
    assert codes(found) == []


def test_joints_that_only_give_way_do_not_vote() -> None:
    log = hand_log()
    still = np.array([True] * 6 + [False])
    wobble = 0.03 * np.sin(2 * np.pi * 5 * log.t)[:, None]
    dq, noise = np.where(still, wobble, log.dq), np.random.default_rng(4).normal(0, 0.3, log.dq.shape)
    torque = np.where(still, noise, friction())
    found = extract(replace(log, dq=dq, tau_J=None, tau_interaction=torque))
    assert [one.verdict for one in found.choice.sign_evidence].count("rises") < 4
    assert found.choice.sign_proved


def test_one_way_motion_says_that_nothing_is_proved() -> None:
    found = extract(hand_log().take_window(0.0, 0.5))
    assert (found.choice.sign_proved, codes(found)) == (False, ["sign_unproved"])


def test_the_robot_s_row_without_a_model_says_what_is_left() -> None:
    found = extract(robot_log(), drive="robot", inertia="none")
    assert found.choice.formula == "F_m = tau_J - g"
    assert "inertia_in_torque" in codes(found)


def test_hand_speed_comes_from_the_kinematics() -> None:
    _, q, dq, _ = motion(7)
    found = extract(hand_log("fr3"), hand=True)
    assert found.hand_speed is not None
    assert np.abs(found.hand_speed - load_arm().hand_speed(q, dq))[500:-500].max() < 0.02
    assert extract(hand_log()).hand_speed is None
    with pytest.raises(UsageError, match="hand"):
        extract(log_of("unknown", 2, tau_interaction=friction(2)), hand=True)


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"torque": "tau_ext"}, "no tau_ext_hat_filtered; has: tau_J"),
        ({"torque": "interaction"}, "no tau_interaction"),
        ({"gravity": "logged"}, "no gravity"),
        ({"drive": "hand", "inertia": "model"}, "link side"),
        ({"gravity": "model", "robot": "none"}, "--robot none"),
    ],
)
def test_contradicting_choices_are_refused(choices: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        extract(hand_log(), **choices)


def test_gravity_of_a_torque_without_gravity_is_refused() -> None:
    with pytest.raises(UsageError, match="neither gravity nor inertia"):
        extract(log_of(tau_ext_hat_filtered=friction()), torque="tau_ext", gravity="model")
    with pytest.raises(UsageError, match="about tau_J"):
        extract(log_of(tau_ext_hat_filtered=friction()), gravity="model")


def test_the_torque_is_one_new_array_column_by_column_and_the_log_is_untouched() -> None:
    log = hand_log()
    found = extract(log)
    assert found.torque.flags.f_contiguous
    assert found.q is log.q
    assert found.dq is log.dq
