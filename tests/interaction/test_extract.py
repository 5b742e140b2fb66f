"""The table of the balance, one row and one source at a time."""

from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.errors import UsageError
from friction_audit.interaction import Interaction, extract_interaction
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.joint_log import Float, JointLog, Source
from friction_audit.robot import load_arm

COULOMB = np.array([0.3, 0.25, 0.3, 0.4, 0.3, 0.2, 0.25])
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


@pytest.mark.parametrize("choices", [{"gravity": "model"}, {"inertia": "model"}, {"drive": "robot"}])
def test_an_unknown_arm_of_seven_joints_is_assumed_a_panda_when_a_model_is_asked_for(choices: dict[str, Any]) -> None:
    found = extract(robot_log("unknown"), **choices)
    assert found.choice.robot == "panda"
    (caution,) = [one for one in found.warnings if one.code == "robot_assumed"]
    assert "N m rms on joints 1 to 7" in caution.message


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
    assert "model_not_used" not in codes(extract(hand_log(), payload=PAYLOAD, gravity_vector=TILTED))
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
    with pytest.raises(UsageError, match=r"made\.csv: joints: 2, .*--urdf"):
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
        ({"drive": "hand", "inertia": "model"}, "far side"),
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
