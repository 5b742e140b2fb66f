"""The interaction torque: source, gravity, inertia, drive and sign, one row of the balance at a time."""

import re
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.joint_log import Finding, Float, JointLog
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.interaction_torque import choose_torque
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.torque_source import known_arm
from friction_audit.reporting.notices import sentence_of
from friction_audit.robot.arm import load_arm
from tests.robot.test_arm import PENDULUM
from tests.synthetic_interaction import choice, cycles_of, log_of as made_log

COULOMB = np.array([0.3, 0.25, 0.3, 0.4, 0.3, 0.2, 0.25])
HAND = (0.73, -0.01, 0.0, 0.03)
PANDA = load_arm()
FORGOTTEN = load_arm(payload=(2.0, 0.05, 0.0, 0.1))
LEFT = {"gravity_error", "torque_offset"}


@cache
def motion(joints: int, seconds: float = 12.0) -> tuple[Float, Float, Float, Float]:
    t = np.arange(0.0, seconds, 0.001)
    omega = 2 * np.pi * np.linspace(0.4, 0.9, joints)
    phase = t[:, None] * omega
    centre = np.array([0.0, -0.8, 0.0, -2.3, 0.0, 1.5, 0.8])[:joints]
    return t, centre - 1.2 / omega * np.cos(phase), 1.2 * np.sin(phase), 1.2 * omega * np.cos(phase)


T, Q, DQ, DDQ = motion(7)
GRAVITY, MOVED = PANDA.gravity(Q), PANDA.inverse_dynamics(Q, DQ, DDQ)


def log_of(robot: str = "panda", joints: int = 7, **channels: Any) -> JointLog:
    return made_log(*motion(joints)[:3], robot=robot, **channels)


@cache
def friction(joints: int = 7) -> Float:
    dq = motion(joints)[2]
    return np.asarray(COULOMB[:joints] * np.sign(dq) + np.random.default_rng(2).normal(0, 0.05, dq.shape))


def hand_log(robot: str = "panda", **channels: Any) -> JointLog:
    """A person moves the arm: tau_J = gravity - F_m."""
    return log_of(robot, tau_J=GRAVITY - friction(), **channels)


def robot_log(robot: str = "panda", **channels: Any) -> JointLog:
    """The arm moves by itself: tau_J = M ddq + c + g + F_m."""
    return log_of(robot, tau_J=MOVED + friction(), **channels)


def extract(log: JointLog, joints: tuple[int, ...] | None = None, *, hand: bool = False, **choices: Any) -> Interaction:
    port = choose_torque(log, TorqueSettings(**choices), joints=joints, hand=hand)
    (part,) = port.log.blocks()
    return port.interaction(part)


def codes(interaction: Interaction) -> list[str]:
    return [caution.code for caution in interaction.warnings]


VENDOR = log_of(tau_ext_hat_filtered=friction())


def rms(torque: Float) -> float:
    return float(np.sqrt((torque[500:-500] ** 2).mean(axis=0)).max())


@pytest.mark.parametrize(
    ("log", "choices", "expected", "cautions"),
    [
        (hand_log(), {}, "tau_J model none hand - panda", []),
        (robot_log(), {}, "tau_J model model robot + panda", ["sign_turned"]),
        (robot_log(), {"drive": "hand"}, "tau_J model none hand - panda", ["sign_contradicts_drive"]),
        (hand_log(), {"inertia": "model"}, "tau_J model model robot + panda", ["sign_contradicts_drive"]),
        (hand_log(gravity=GRAVITY), {}, "tau_J logged none hand - none", []),
        (robot_log(gravity=GRAVITY), {"drive": "robot"}, "tau_J logged model robot + panda", []),
        (robot_log(), {"drive": "robot", "inertia": "none"}, "tau_J model none robot + panda", ["inertia_in_torque"]),
        (
            log_of("unknown", tau_ext_hat_filtered=-friction()),
            {},
            "tau_ext removed none hand - none",
            ["tau_ext_filtered"],
        ),
        (
            log_of("unknown", tau_ext_hat_filtered=friction()),
            {},
            "tau_ext removed none robot + none",
            ["tau_ext_filtered", "sign_turned"],
        ),
        (log_of("unknown", tau_interaction=friction()), {}, "interaction removed none hand + none", []),
        (log_of("unknown", tau_interaction=-friction()), {}, "interaction removed none hand - none", ["sign_turned"]),
        (hand_log(tau_ext_hat_filtered=-friction()), {}, "tau_J model none hand - panda", []),
    ],
)
def test_the_row_of_the_balance(log: JointLog, choices: dict[str, Any], expected: str, cautions: list[str]) -> None:
    found = extract(log, **choices)
    made = found.choice
    sign = {1: "+", -1: "-"}[made.sign]
    assert f"{made.source} {made.gravity} {made.inertia} {made.drive} {sign} {made.robot}" == expected
    assert codes(found) == cautions
    assert made.sign_turned == ("sign_turned" in cautions)
    assert made.sign_proved == ("sign_contradicts_drive" not in cautions)
    if made.sign_proved and "inertia_in_torque" not in cautions:
        assert [one.verdict for one in made.sign_evidence] == ["rises"] * 7
        assert rms(found.torque - friction()) < 0.02


def test_a_compensator_of_the_wrong_sign_is_suspected_where_no_row_and_no_sign_rises() -> None:
    compensation = 1.5 * COULOMB * np.sign(DQ)
    wrong = log_of("unknown", tau_interaction=friction() - compensation, tau_compensation=-compensation)
    (caution,) = extract(wrong, drive="hand").warnings
    assert caution.code == "sign_contradicts_drive"
    assert "tau_compensation has the wrong sign" in sentence_of(caution)


def test_auto_trusts_the_vendor_s_estimate_if_a_payload_is_missing_from_the_model() -> None:
    gravity = load_arm(payload=HAND).gravity(Q)
    log = log_of("panda", tau_J=gravity - friction(), tau_ext_hat_filtered=-friction())
    found = extract(log)
    assert found.choice.source == "tau_ext"
    assert codes(found) == ["tau_ext_filtered", "payload_missing"]
    with_hand = extract(log, payload=HAND)
    assert (with_hand.choice.source, with_hand.choice.payload) == ("tau_J", HAND)
    assert_allclose(with_hand.torque, friction(), atol=0.01)


def test_a_dead_torque_is_no_missing_payload() -> None:
    torque = np.where(np.arange(7) == 1, 3.0, load_arm().gravity(Q) - friction())
    log = log_of("panda", tau_J=torque, tau_ext_hat_filtered=-friction())
    dead = replace(log.source, findings=(Finding(code="torque_dead", message="", joint=2),))
    assert [extract(one).choice.source for one in (log, replace(log, source=dead))] == ["tau_ext", "tau_J"]


def test_no_robot_is_assumed_that_neither_log_nor_user_names() -> None:
    found = extract(robot_log("unknown"), drive="robot")
    assert (found.choice.robot, found.choice.gravity, found.choice.inertia) == ("none", "in-torque", "none")
    assert found.choice.gravity == "in-torque"
    (caution,) = [one for one in found.warnings if one.code == "gravity_in_torque"]
    assert caution.numbers["command"] == "`friction-audit estimate made.csv --drive robot --robot panda`"
    named = extract(robot_log("unknown"), drive="robot", robot="panda")
    assert (named.choice.robot, named.choice.gravity, named.choice.inertia) == ("panda", "model", "model")


def test_an_fr3_does_not_get_a_panda_s_inertias_unasked() -> None:
    assert codes(extract(hand_log("fr3")))[:2] == ["no_model", "gravity_in_torque"]
    with pytest.raises(UsageError, match="Franka Research 3"):
        extract(hand_log("fr3"), gravity="model")
    assert extract(hand_log("fr3"), gravity="model", robot="panda").choice.robot == "panda"


@pytest.mark.parametrize("option", ["gravity", "inertia"])
def test_a_model_of_an_arm_without_a_name_is_refused_with_the_commands(option: str) -> None:
    chosen: dict[str, Any] = {option: "model"}
    with pytest.raises(UsageError) as refused:
        extract(robot_log("unknown"), **chosen)
    assert f"`friction-audit estimate made.csv --{option} model --robot panda`" in str(refused.value)
    assert "without a model: `friction-audit estimate made.csv --robot none`" in str(refused.value)
    with pytest.raises(UsageError, match=r"joints: 2\).*`friction-audit estimate made\.csv .*--urdf FILE`"):
        extract(log_of("unknown", 2, tau_J=friction(2)), **chosen)


@pytest.mark.parametrize("drive", ["hand", "robot"])
def test_a_model_further_from_the_torque_than_none_is_refused_with_the_numbers(drive: str) -> None:
    """Torques of another arm, a few newton metres, and a torque from which gravity is removed already."""
    other = log_of("unknown", tau_J=2.0 * np.cos(Q) + friction())
    with pytest.raises(UsageError) as refused:
        extract(other, robot="panda", drive=drive)
    assert f"friction-audit estimate made.csv --drive {drive} --robot none" in str(refused.value)
    assert len(re.findall(r"\d+\.\d\d", str(refused.value))) == 14
    with pytest.raises(UsageError, match=r"already removed from tau_J: .*--gravity removed"):
        extract(log_of("panda", tau_J=friction()), drive=drive)
    log = robot_log()
    assert log.tau_J is not None
    dead = replace(log.source, findings=(Finding(code="torque_dead", message="", joint=2),))
    torque = np.where(np.arange(7) == 1, 0.0, log.tau_J)
    assert extract(replace(log, source=dead, tau_J=torque), drive=drive).choice.robot == "panda"


def test_a_hole_in_the_log_refuses_no_model() -> None:
    """A spline of the inertial torque must not go on into the hole: it once had millions of newton metres there."""
    log, kept = robot_log(), (T < 4.0) | (T > 7.0)
    assert log.tau_J is not None
    found = extract(replace(log, t=T[kept], q=Q[kept], dq=DQ[kept], tau_J=log.tau_J[kept]))
    assert found.choice.robot == "panda"
    away = (np.abs(T[kept] - 4.0) > 0.3) & (np.abs(T[kept] - 7.0) > 0.3)
    assert_allclose(found.torque[away], extract(log).torque[kept][away], atol=0.02)


@pytest.mark.parametrize("log", [hand_log(), robot_log(), robot_log(gravity=GRAVITY)], ids=["hand", "robot", "logged"])
def test_a_joint_whose_torque_has_the_opposite_sign_is_named(log: JointLog) -> None:
    assert log.tau_J is not None
    assert "torque_flipped" not in codes(extract(log))
    found = extract(replace(log, tau_J=np.where(np.arange(7) == 3, -log.tau_J, log.tau_J)))
    (caution,) = [one for one in found.warnings if one.code == "torque_flipped"]
    assert sentence_of(caution) == "joint 4: gravity fits the torque with the opposite sign: turn it with --flip 4"


@pytest.mark.parametrize(("turned", "joints"), [((2, 4), "2,4"), (range(1, 8), "1,2,3,4,5,6,7")])
def test_a_torque_of_the_opposite_sign_is_refused_with_the_option(turned: tuple[int, ...], joints: str) -> None:
    log = robot_log()
    assert log.tau_J is not None
    sign = np.where(np.isin(np.arange(1, 8), turned), -1.0, 1.0)
    with pytest.raises(UsageError, match=f"opposite sign it would explain it: --flip {joints}\\."):
        extract(replace(log, tau_J=sign * log.tau_J))


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
    assert (found.choice.gravity, found.choice.robot) == ("in-torque", "none")
    with pytest.raises(UsageError, match="is a motor current"):
        extract(current, gravity="model")


def test_the_cycles_of_a_joint_do_not_depend_on_which_joints_are_kept() -> None:
    """With gravity in the torque a cycle ends where every joint of the arm is back, also those not asked for."""
    log = robot_log("unknown")
    every, (alone,) = (cycles_of(extract(log, kept, drive="robot")) for kept in (None, (4,)))
    assert alone.start.tolist() == every[3].start.tolist()
    assert alone.reason.tolist() == every[3].reason.tolist()


@pytest.mark.parametrize(("robot", "joints"), [("unknown", 1), ("panda", 1), ("panda", 6)])
def test_logged_gravity_needs_no_model_where_the_log_has_other_joints(robot: str, joints: int) -> None:
    log = log_of(robot, joints, tau_J=5.0 + friction(joints), gravity=np.full((12_000, joints), 5.0))
    found = extract(log, drive="robot")
    assert_allclose(found.torque, friction(joints), atol=1e-12)
    assert (found.choice.gravity, found.choice.inertia) == ("logged", "none")
    # A joint alone has its kinetic energy back at the end of every cycle.
    assert codes(found) == (["inertia_in_torque"] if joints > 1 else [])


def test_options_that_are_not_used_are_named_and_those_that_are_used_are_not(tmp_path: Path) -> None:
    urdf = tmp_path / "panda.urdf"
    urdf.write_bytes(resources.files("friction_audit.robot").joinpath("panda.urdf").read_bytes())
    log = log_of("unknown", tau_interaction=friction())
    (caution,) = extract(log, payload=HAND, urdf=urdf, gravity_vector=(9.81, 0.0, 0.0)).warnings
    assert caution.code == "model_not_used"
    assert sentence_of(caution).startswith("--payload, --urdf, --gravity-vector: not used")
    (caution,) = extract(log, urdf=urdf, payload=HAND, hand=True).warnings
    assert sentence_of(caution).startswith("--payload: not used")  # the speed of the hand comes from the URDF
    assert "model_not_used" not in codes(extract(hand_log(), payload=HAND, gravity_vector=(1.0, 0.0, -9.76)))
    assert "model_not_used" not in codes(extract(hand_log("unknown"), urdf=urdf))
    logged = hand_log(gravity=GRAVITY)
    assert codes(extract(logged, urdf=urdf)) == []  # the direction of gravity is the model's
    assert codes(extract(logged, payload=HAND)) == ["model_not_used"]


def test_any_arm_by_its_urdf_of_which_turning_joints_count_that_are_no_fingers(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.urdf"
    path.write_text(PENDULUM.format(kind="continuous"))
    _, q, _, ddq = motion(1)
    log = log_of("unknown", 1, tau_J=0.5 * ddq + 9.81 * np.sin(q) + friction(1))
    found = extract(log, urdf=path, drive="robot")
    assert (found.choice.robot, found.choice.inertia) == ("pendulum", "model")
    assert rms(found.torque - friction(1)) < 0.01


def test_a_compensator_s_torque_is_added_up_and_counts_in_the_proof() -> None:
    compensation, passivity = 1.5 * COULOMB * np.sign(DQ), -0.1 * np.sign(DQ)
    log = hand_log(tau_compensation=compensation, tau_passivity=passivity)
    assert log.tau_J is not None
    # Overcompensated: the hand's torque is against the motion, and only the sum of both is what friction takes.
    found = extract(replace(log, tau_J=log.tau_J + compensation + passivity))
    assert found.compensation is not None
    assert_allclose(found.compensation, compensation + passivity)
    assert (found.choice.drive, found.choice.sign_proved) == ("hand", True)
    assert extract(replace(log, tau_compensation=None)).compensation is not None
    assert extract(hand_log()).compensation is None


def test_selected_joints_are_the_same_as_among_all_and_the_log_is_untouched() -> None:
    log = hand_log()
    whole, some = extract(log), extract(log, joints=(5, 2))
    assert (some.joint_numbers, some.joint_names) == ((2, 5), ("joint2", "joint5"))
    assert_allclose(some.torque, whole.torque[:, [1, 4]], atol=1e-12)
    assert_array_equal(some.q, log.q[:, [1, 4]])
    assert some.choice == whole.choice
    assert whole.torque.flags.f_contiguous
    assert (whole.q is log.q, whole.dq is log.dq) == (True, True)
    with pytest.raises(UsageError, match=r"--joints 0,9: not in made\.csv; its joints are 1 \(joint1\), 2"):
        extract(log, joints=(0, 3, 9))


def test_a_joint_that_disagrees_is_named() -> None:
    log = hand_log()
    assert log.tau_J is not None
    found = extract(replace(log, tau_J=log.tau_J + np.where(np.arange(7) == 2, 2 * friction(), 0.0)))
    assert found.choice.sign_proved
    assert [(one.code, one.joint) for one in found.warnings] == [("sign_disagrees", 3)]


@pytest.mark.parametrize("dead", [frozenset({1, 2, 3, 4}), frozenset()])
def test_joints_without_a_torque_cast_no_vote(dead: frozenset[int]) -> None:
    """Four joints whose torque is a few counts that go with the motion, three that are right."""
    counts = 0.001 * np.round(2.0 * np.tanh(DQ))
    log = log_of(tau_interaction=np.where(np.arange(7) < 4, -counts, friction()))
    findings = tuple(Finding(code="torque_dead", message="", joint=joint) for joint in dead)
    found = extract(replace(log, source=replace(log.source, findings=findings)))
    assert (found.choice.sign, found.choice.sign_proved) == (1, bool(dead))
    assert codes(found) == ([] if dead else ["sign_unproved"])


def test_a_bus_that_updates_a_joint_every_seventh_row_has_its_sign_proved() -> None:
    """Rows at rest are kept, rows that repeat in motion were left out: the steps in motion are 70 ms of a 10 ms log."""
    t = np.arange(0.0, 60.0, 0.01)
    dq = np.where(t % 5.0 < 2.5, 0.8 * np.sin(2 * np.pi * t / 2.5) * np.sign(np.sin(np.pi * t / 5.0 + 0.1)), 0.0)
    fresh = (dq == 0.0) | (np.arange(len(t)) % 7 == 0)
    torque = 0.116 * np.sign(dq) + 0.04 * dq + 0.01 * np.random.default_rng(3).normal(size=len(t))
    signals = {"q": np.cumsum(dq) * 0.01, "dq": dq, "tau_J": torque}
    channels = {name: values[fresh] for name, values in signals.items()}
    made = extract(made_log(t[fresh] - t[fresh][0], **channels)).choice
    assert (made.drive, made.sign_proved, made.sign_turned) == ("robot", True, True)


@pytest.mark.parametrize(
    ("forgotten", "short", "said"), [(True, False, "payload"), (False, False, ""), (True, True, "no payload")]
)
def test_gravity_that_is_left_is_said_as_rms_where_it_can_be_measured(forgotten: bool, short: bool, said: str) -> None:
    swing, centre = 0.02 if short else 1.0, Q.mean(axis=0)
    q, arm = centre + swing * (Q - centre), FORGOTTEN if forgotten else PANDA
    log = replace(log_of("panda", tau_J=arm.gravity(q) - friction()), q=q, dq=swing * DQ)
    found = {one.joint or 0: one for one in extract(log, drive="hand").warnings if one.code in LEFT}
    if not said:
        assert not found
        return
    truth = np.sqrt(np.mean((arm.gravity(q) - PANDA.gravity(q)) ** 2, axis=0))
    assert 4 in found
    assert 1 not in found  # its axis is vertical
    for joint, caution in found.items():
        size = float(re.findall(r"(-?\d+\.\d) N m", sentence_of(caution))[0])
        # Where other joints move too, only a part goes with the joint's own posture: a lower bound.
        if caution.code == "gravity_error" or short:
            assert (0.9 if short else 0.3) * truth[joint - 1] < abs(size) < 1.15 * truth[joint - 1]
        assert ("the model lacks the payload" in sentence_of(caution)) == (caution.code == "gravity_error")
    assert any(one.code == "gravity_error" for one in found.values()) == (said == "payload")


def test_gravity_that_is_declared_to_be_inside_is_no_error_nor_is_a_current() -> None:
    log = log_of("unknown", tau_J=FORGOTTEN.inverse_dynamics(Q, DQ, DDQ) + friction())
    assert not LEFT & set(codes(extract(log, drive="robot")))
    pulled = log_of("unknown", tau_interaction=friction() + 4.0 * np.sin(Q))
    assert "gravity_error" in codes(extract(pulled))
    assert not LEFT & set(codes(extract(replace(pulled, source=replace(pulled.source, torque_unit="A")))))


def test_joints_that_only_give_way_do_not_vote() -> None:
    log, still = hand_log(), np.array([True] * 6 + [False])
    wobble = 0.03 * np.sin(2 * np.pi * 5 * log.t)[:, None]
    dq, noise = np.where(still, wobble, log.dq), np.random.default_rng(4).normal(0, 0.3, log.dq.shape)
    found = extract(replace(log, dq=dq, tau_J=None, tau_interaction=np.where(still, noise, friction())))
    assert [one.verdict for one in found.choice.sign_evidence].count("rises") < 4
    assert found.choice.sign_proved


def test_hand_speed_comes_from_the_kinematics() -> None:
    speed = choose_torque(hand_log("fr3"), TorqueSettings(), hand=True).hand_speed
    assert speed is not None
    assert np.abs(speed - PANDA.hand_speed(Q, DQ))[500:-500].max() < 0.02
    assert choose_torque(hand_log(), TorqueSettings()).hand_speed is None
    for log in (log_of("unknown", 2, tau_interaction=friction(2)), hand_log("unknown")):
        with pytest.raises(UsageError, match="--cycles-from hand"):
            extract(log, hand=True)


@pytest.mark.parametrize(
    ("robot", "asked", "used", "joints", "known"),
    [
        ("panda", "auto", "none", 7, True),
        ("unknown", "panda", "none", 7, True),
        ("unknown", "auto", "panda", 7, True),
        ("unknown", "auto", "none", 7, False),
        ("fr3", "auto", "none", 7, False),
        ("panda", "none", "none", 7, False),
        ("panda", "auto", "none", 1, False),
    ],
)
def test_whose_model_is_known(robot: str, asked: str, used: str, joints: int, known: bool) -> None:
    log = log_of(robot, joints, tau_J=friction(joints))
    assert (known_arm(log, TorqueSettings(robot=asked), replace(choice(), robot=used)) is not None) == known


@pytest.mark.parametrize(
    ("log", "choices", "message"),
    [
        (hand_log(), {"torque": "interaction"}, "no tau_interaction"),
        (hand_log(), {"gravity": "logged"}, "no gravity"),
        (hand_log(), {"drive": "hand", "inertia": "model"}, "link side"),
        (hand_log(), {"gravity": "model", "robot": "none"}, "--robot none"),
        (VENDOR, {"torque": "tau_ext", "gravity": "model"}, "neither gravity nor inertia"),
        (VENDOR, {"gravity": "model"}, "about tau_J"),
    ],
)
def test_wrong_and_contradicting_choices_are_refused(log: JointLog, choices: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        extract(log, **choices)
