"""The rigid-body model against laws of mechanics and numbers known by hand."""

import sys
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot import Arm, load_arm

READY = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
HAND = (0.73, -0.01, 0.0, 0.03)
PANDA_NAMES = tuple(f"panda_joint{number}" for number in range(1, 8))
PENDULUM = """<robot name="pendulum">
  <link name="base"/>
  <joint name="hinge" type="{kind}">
    <parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
  </joint>
  <link name="bob"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="slider" type="prismatic">
    <parent link="bob"/><child link="carriage"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="carriage"/>
  <joint name="finger_joint1" type="revolute">
    <parent link="carriage"/><child link="finger"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="finger"/>
</robot>"""


def random_motion(rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    return rng.normal(size=(rows, 7)), rng.normal(size=(rows, 7)), rng.normal(size=(rows, 7))


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.urdf"
    path.write_text(PENDULUM.format(kind="continuous"))
    return path


def potential_energy(arm: Arm, q: Float) -> Float:
    data = arm.model.createData()
    return np.array([pinocchio.computePotentialEnergy(arm.model, data, position) for position in q])


def hand_pose(arm: Arm, q: Float) -> Float:
    data = arm.model.createData()
    pinocchio.framesForwardKinematics(arm.model, data, q)
    return np.asarray(data.oMf[arm.model.getFrameId(arm.flange)].homogeneous)


def test_gravity_is_the_gradient_of_the_potential_energy() -> None:
    arm, (q, _, _), step = load_arm(payload=HAND), random_motion(3), 1e-6
    gradient = np.empty_like(q)
    for joint in range(7):
        shift = step * np.eye(7)[joint]
        gradient[:, joint] = (potential_energy(arm, q + shift) - potential_energy(arm, q - shift)) / (2 * step)
    np.testing.assert_allclose(arm.gravity(q), gradient, atol=1e-6)


def test_inverse_dynamics_at_rest_is_gravity() -> None:
    arm, (q, _, _) = load_arm(), random_motion(5)
    np.testing.assert_allclose(arm.inverse_dynamics(q, np.zeros_like(q), np.zeros_like(q)), arm.gravity(q), atol=1e-12)


def test_power_of_inverse_dynamics_is_the_change_of_energy() -> None:
    arm, step = load_arm(), 1e-4
    t = np.arange(0, 0.2, step)
    q = READY + np.sin(3 * t)[:, None] * np.linspace(0.2, 0.5, 7)
    dq = 3 * np.cos(3 * t)[:, None] * np.linspace(0.2, 0.5, 7)
    ddq = -9 * np.sin(3 * t)[:, None] * np.linspace(0.2, 0.5, 7)
    power = (arm.inverse_dynamics(q, dq, ddq) * dq).sum(axis=1)
    kinetic = 0.5 * ((arm.inverse_dynamics(q, 0 * dq, dq) - arm.gravity(q)) * dq).sum(axis=1)
    energy = potential_energy(arm, q) + kinetic
    assert np.trapezoid(power, t) == pytest.approx(energy[-1] - energy[0], rel=1e-6)


def test_hand_pose_at_the_ready_pose() -> None:
    pose = hand_pose(load_arm(), READY)
    # Franka's own ready pose: end effector at 0.3069, 0, 0.4869 with the hand, whose length is 0.1034; pointing down.
    assert pose[2, 2] == pytest.approx(-1)
    assert pose[:3, 3] == pytest.approx([0.3069, 0.0, 0.5903], abs=2e-4)


def test_stretched_upwards_the_flange_is_where_the_lengths_say() -> None:
    assert hand_pose(load_arm(), np.zeros(7))[:3, 3] == pytest.approx([0.088, 0, 0.333 + 0.316 + 0.384 - 0.107])


def test_the_hand_shifts_gravity_at_the_ready_pose() -> None:
    shift = (load_arm(payload=HAND).gravity(READY[None]) - load_arm().gravity(READY[None]))[0]
    assert shift == pytest.approx([0.0, -2.2, 0.0, 3.4, 0.0, 0.6, 0.0], abs=0.1)


def test_a_tilted_base_turns_gravity() -> None:
    upright, lying = load_arm(), load_arm(gravity_vector=(-9.81, 0.0, 0.0))
    assert abs(upright.gravity(READY[None])[0, 0]) < 1e-12
    turned = READY + np.array([np.pi / 2, 0, 0, 0, 0, 0, 0])
    assert abs(lying.gravity(turned[None])[0, 0]) > 1


def test_hand_speed_is_the_lever_times_the_speed_of_joint_1() -> None:
    dq = np.array([[0.5, 0, 0, 0, 0, 0, 0]])
    arm = load_arm()
    x, y = hand_pose(arm, READY)[:2, 3]
    assert arm.hand_speed(READY[None], dq)[0] == pytest.approx(0.5 * np.hypot(x, y))


def test_joints_are_matched_by_name_when_the_names_agree() -> None:
    q, dq, ddq = random_motion(4)
    order = [3, 0, 6, 1, 5, 2, 4]
    plain = load_arm().inverse_dynamics(q, dq, ddq)
    names = tuple(PANDA_NAMES[column] for column in order)
    matched = load_arm().matched(names, "log")
    np.testing.assert_allclose(matched.inverse_dynamics(q[:, order], dq[:, order], ddq[:, order]), plain[:, order])


def test_joints_of_other_names_are_taken_in_order() -> None:
    arm = load_arm().matched(tuple(f"fer_joint{number}" for number in range(1, 8)), "log")
    assert arm.columns == tuple(range(7))


def test_another_number_of_joints_is_refused_with_both_named() -> None:
    with pytest.raises(UsageError, match=r"log\.csv: joints: 2 \(a, b\); the model panda has 7 .*--urdf"):
        load_arm().matched(("a", "b"), "log.csv")


def test_any_urdf_only_turning_joints_that_are_no_fingers_count(pendulum: Path) -> None:
    arm = load_arm(pendulum)
    assert (arm.name, arm.joint_names) == ("pendulum", ("hinge",))
    q = np.array([[0.0], [np.pi / 2], [7.0]])
    # A bob on 0.5 m, 2 kg: the torque about y that holds it.
    np.testing.assert_allclose(arm.gravity(q)[:, 0], 2 * 9.81 * 0.5 * np.sin(q[:, 0]), atol=1e-9)
    zero = np.zeros((1, 1))
    assert arm.inverse_dynamics(zero, zero, zero + 1)[0, 0] == pytest.approx(2 * 0.5**2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("not xml", "not XML"),
        ("<sdf/>", "<sdf>; expected <robot>"),
        ("<robot name='r'><link name='a'/></robot>", "no revolute joint"),
        (PENDULUM.format(kind="revolute").replace('<mass value="2"/>', ""), "link bob: inertial without <mass>"),
        (
            PENDULUM.format(kind="revolute").replace('<mass value="2"/>', '<mass value="two"/>'),
            "link bob: mass 'two'; expected a number",
        ),
        (PENDULUM.format(kind="revolute").replace('child link="bob"', 'child link="nobody"'), "cannot read it"),
    ],
)
def test_a_malformed_urdf_is_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "broken.urdf"
    path.write_text(text)
    with pytest.raises(UsageError, match=message) as caught:
        load_arm(path)
    assert "broken.urdf" in str(caught.value)


@pytest.mark.parametrize(
    ("sound", "wrong", "message"),
    [
        ('<mass value="2"/>', '<mass value="inf"/>', "link bob: mass 'inf'"),
        ('<mass value="2"/>', '<mass value="nan"/>', "link bob: mass 'nan'"),
        ('<mass value="2"/>', '<mass value="-2"/>', "link bob: mass '-2'; .* at least 0"),
        ('<mass value="2"/>', '<mass value="1e300"/>', "link bob: mass '1e300'"),
        ('<mass value="2"/>', '<mass value="0"/>', "no link has a mass"),
        ('ixx="0"', 'ixx="big"', "link bob: inertia ixx 'big'"),
        ('izz="0"', "", "link bob: inertia izz ''"),
        ('"0 0 -0.5"', '"0 0 -0,5"', "link bob: inertial origin xyz '0 0 -0,5'; expected 3 numbers"),
        ('"0 0 -0.5"', '"0 -0.5"', "link bob: inertial origin xyz '0 -0.5'"),
        ('xyz="0 0 -0.5"', 'rpy="0 0 x"', "link bob: inertial origin rpy '0 0 x'"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "joint hinge: axis '0 0 0' has no direction"),
        ('<axis xyz="0 1 0"/>', '<origin xyz="0 inf 0"/>', "joint hinge: origin xyz '0 inf 0'"),
        ('"prismatic"', '"planar"', "joint slider: type planar; expected one of revolute"),
        ('"prismatic"', '"floating"', "joint slider: type floating"),
    ],
)
def test_every_number_of_a_urdf_is_checked(tmp_path: Path, sound: str, wrong: str, message: str) -> None:
    text = PENDULUM.format(kind="revolute")
    assert sound in text
    path = tmp_path / "wrong.urdf"
    path.write_text(text.replace(sound, wrong, 1))
    with pytest.raises(UsageError, match=rf"wrong\.urdf: .*{message}"):
        load_arm(path)


def test_all_faults_of_a_urdf_are_named_at_once(tmp_path: Path) -> None:
    text = PENDULUM.format(kind="revolute").replace('value="2"', 'value="two"').replace("0 1 0", "0 0 0")
    (tmp_path / "wrong.urdf").write_text(text)
    with pytest.raises(UsageError, match=r"link bob: mass .*; joint hinge: axis"):
        load_arm(tmp_path / "wrong.urdf")


def test_a_chain_without_end_is_refused(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{n}"/>' for n in range(20_000))
    joints = "".join(
        f'<joint name="j{n}" type="revolute"><parent link="l{n}"/><child link="l{n + 1}"/></joint>'
        for n in range(19_999)
    )
    (tmp_path / "long.urdf").write_text(f'<robot name="r">{links}{joints}</robot>')
    with pytest.raises(UsageError, match="20000 links; expected at most 1000"):
        load_arm(tmp_path / "long.urdf")


def test_a_missing_urdf_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"nowhere\.urdf: No such file"):
        load_arm(tmp_path / "nowhere.urdf")


@pytest.mark.parametrize("payload", [(0.0, 0, 0, 0), (-1.0, 0, 0, 0), (float("nan"), 0, 0, 0)])
def test_a_payload_without_mass_is_refused(payload: tuple[float, float, float, float]) -> None:
    with pytest.raises(UsageError, match="--payload"):
        load_arm(payload=payload)


def test_without_pinocchio_the_message_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(UsageError, match="Windows"):
        load_arm()


def test_gravity_direction_explains_what_a_displaced_mass_does() -> None:
    """A point mass in the last link acts on its axis like a constant times the direction of gravity across it."""
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.0, 1.0, (50, 7))
    plain, heavy = load_arm(), load_arm(payload=(1.0, 0.05, 0.02, 0.1))
    error = (heavy.gravity(q) - plain.gravity(q))[:, 6]
    across = plain.gravity_direction(q)[:, 6]
    left = np.linalg.lstsq(across, error, rcond=None)[1]
    assert np.abs(error).max() > 0.3
    assert left[0] < 1e-20


def test_gravity_direction_is_zero_about_a_vertical_axis_and_turns_with_a_horizontal_one() -> None:
    q = np.zeros((3, 7))
    q[:, 1] = [0.0, 0.5, 1.0]
    direction = load_arm().gravity_direction(q)
    np.testing.assert_allclose(direction[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(direction[:, 1], axis=1), 1.0)
    turned = np.arccos(direction[0, 1] @ direction[1:, 1].T)
    np.testing.assert_allclose(turned, [0.5, 1.0])
