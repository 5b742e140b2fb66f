"""The rigid-body model against equations by hand, another library's numbers and laws of mechanics."""

import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.arm import load_arm, read_urdf
from friction_audit.robot.regressor import random_motion, regressor_entries, tilt_torque

READY = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
HAND = (0.73, -0.01, 0.0, 0.03)
PANDA_NAMES = tuple(f"panda_joint{number}" for number in range(1, 8))
ARM = load_arm()
MOTION = random_motion(7, moving=True)
PENDULUM = """<robot name="pendulum">
  <link name="base"/>
  <joint name="hinge" type="{kind}">
    <parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
  </joint>
  <link name="bob"><visual><geometry><mesh filename="package://nowhere/bob.dae"/></geometry></visual>
    <inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="slider" type="prismatic">
    <parent link="bob"/><child link="carriage"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="carriage"/>
  <joint name="finger_joint1" type="revolute">
    <parent link="carriage"/><child link="finger"/><axis xyz="0 0 1"/>
  </joint>
  <link name="finger"/>
  <joint name="coupled" type="revolute"><parent link="bob"/><child link="cog"/><mimic joint="hinge"/></joint>
  <link name="cog"/>
  <transmission name="gear"/>
</robot>"""


def write(folder: Path, text: str) -> Path:
    path = folder / "arm.urdf"
    path.write_text(text)
    return path


def flange_at(q: Float) -> tuple[Float, Float]:
    data = mujoco.MjData(ARM.model)
    data.qpos[:] = q
    mujoco.mj_kinematics(ARM.model, data)
    return data.body(ARM.flange).xpos.copy(), data.body(ARM.flange).xmat.reshape(3, 3).copy()


def test_two_links_by_hand(tmp_path: Path) -> None:
    """Two point masses at the ends of two rods that swing in a vertical plane."""
    m, l = (1.5, 0.7), (0.4, 0.3)  # noqa: E741
    links = "".join(
        f'<link name="rod{k}"><inertial><origin xyz="{l[k]} 0 0"/><mass value="{m[k]}"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>'
        f'<joint name="j{k}" type="continuous"><parent link="{("base", "rod0")[k]}"/><child link="rod{k}"/>'
        f'<origin xyz="{k * l[0]} 0 0"/><axis xyz="0 -1 0"/><dynamics damping="5" friction="3"/></joint>'
        for k in range(2)
    )
    arm = load_arm(write(tmp_path, f'<robot name="two"><link name="base"/>{links}</robot>'))
    q, v, a = np.random.default_rng(0).normal(size=(3, 20, 2))
    near, far, mixed = (m[0] + m[1]) * l[0] ** 2, m[1] * l[1] ** 2, m[1] * l[0] * l[1]
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    weight = 9.81 * m[1] * l[1] * np.cos(q.sum(axis=1))
    first = (near + far + 2 * mixed * c) * a[:, 0] + (far + mixed * c) * a[:, 1]
    first += -mixed * s * (2 * v[:, 0] + v[:, 1]) * v[:, 1] + 9.81 * (m[0] + m[1]) * l[0] * np.cos(q[:, 0]) + weight
    second = (far + mixed * c) * a[:, 0] + far * a[:, 1] + mixed * s * v[:, 0] ** 2 + weight
    assert_allclose(arm.inverse_dynamics(q, v, a), np.column_stack([first, second]), atol=1e-12)
    assert_allclose(arm.mass_diagonal(q), np.column_stack([near + far + 2 * mixed * c, 0 * c + far]), atol=1e-12)


def test_torques_of_the_panda_are_those_of_pinocchio() -> None:
    """Stored from Pinocchio 3 with the same URDF."""
    q = np.array([READY, [0.3, -0.5, 0.7, -1.9, -0.4, 1.8, 0.2]])
    dq = np.array([np.zeros(7), [0.5, -0.8, 0.3, 1.1, -0.6, 0.9, -1.2]])
    ddq = np.array([np.zeros(7), [1.0, 2.0, -3.0, 0.5, 4.0, -2.0, 6.0]])
    at_ready = [0.0, -3.9184729258, -0.6798068197, 21.9030859530, 0.6844842234, 2.2732410922, 0.0]
    still = [0.0, -5.4318263519, -9.3693145243, 20.8046773869, -0.1013764979, 2.0114706747, 0.0135300041]
    moving = [-1.3258912832, -3.9886911047, -12.4753661767, 19.2139364678, -0.0131244041, 1.3848540627, 0.0554410834]
    tilted = [-0.1861730158, -1.4009999107, -4.3620645070, 15.1122364392, 0.5952755844, 1.2240677291, 0.0818947257]
    arm = load_arm(payload=HAND)
    assert_allclose(arm.gravity(q), [at_ready, still], atol=1e-10)
    assert_allclose(arm.inverse_dynamics(q, dq, ddq), [at_ready, moving], atol=1e-10)
    assert_allclose(arm.hand_speed(q, dq), [0.0, 1.1393115165], atol=1e-10)
    assert_allclose(load_arm(gravity_vector=(1.0, -3.0, -9.0)).inverse_dynamics(q, dq, ddq)[1], tilted, atol=1e-10)


def test_gravity_is_inverse_dynamics_at_rest_for_any_axes(tmp_path: Path) -> None:
    axes = iter(("0 0 -1", "1 0 0", "0.3 -0.5 0.2", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1"))
    text = re.sub('axis xyz="[^"]*"', lambda _: f'axis xyz="{next(axes)}"', read_urdf(None).decode())
    arm = load_arm(write(tmp_path, text), HAND, gravity_vector=(1.0, -3.0, -9.0))
    still = np.zeros_like(MOTION[0])
    assert_allclose(arm.gravity(MOTION[0]), arm.inverse_dynamics(MOTION[0], still, still), atol=1e-12)


def test_the_flange_is_where_the_published_lengths_put_it() -> None:
    # Franka's own ready pose: end effector at 0.3069, 0, 0.4869 with the hand, whose length is 0.1034; pointing down.
    position, orientation = flange_at(READY)
    assert orientation[2, 2] == pytest.approx(-1)
    assert position == pytest.approx([0.3069, 0.0, 0.5903], abs=2e-4)
    assert flange_at(np.zeros(7))[0] == pytest.approx([0.088, 0, 0.333 + 0.316 + 0.384 - 0.107])


def test_joints_are_matched_by_name_when_the_names_agree() -> None:
    order = [3, 0, 6, 1, 5, 2, 4]
    matched = ARM.matched(tuple(PANDA_NAMES[column] for column in order), "log")
    turned = tuple(signal[:, order] for signal in MOTION)
    assert_allclose(matched.inverse_dynamics(*turned), ARM.inverse_dynamics(*MOTION)[:, order])
    assert_allclose(matched.gravity_direction(turned[0]), ARM.gravity_direction(MOTION[0])[:, order])
    assert ARM.matched(tuple(f"fer_joint{number}" for number in range(1, 8)), "log") is ARM
    with pytest.raises(UsageError, match=r"log\.csv: joints: 2 \(a, b\); the model panda needs 7 .*--urdf"):
        ARM.matched(("a", "b"), "log.csv")


def test_arms_of_one_urdf_come_in_the_order_of_their_joints_names(tmp_path: Path) -> None:
    def side(name: str) -> str:
        bob = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
        return "".join(
            f'<link name="{name}_{k}">{bob}</link><joint name="{name}_j{k}" type="revolute"><parent link="'
            f'{f"{name}_{k - 1}" if k else "base"}"/><child link="{name}_{k}"/><axis xyz="0 1 0"/></joint>'
            for k in range(2)
        )

    text = f'<robot name="two"><link name="base"/>{side("right")}{side("left")}</robot>'
    assert load_arm(write(tmp_path, text)).joint_names == ("left_j0", "left_j1", "right_j0", "right_j1")


@pytest.mark.parametrize(
    ("sound", "wrong", "message"),
    [
        ("<robot name", "<", "not XML"),
        ("robot", "sdf", "<sdf>; expected <robot>"),
        ('"hinge" type="revolute"', '"hinge" type="fixed"', "no revolute joint"),
        ('<mass value="2"/>', "", "link bob: inertial without <mass>"),
        ('<mass value="2"/>', '<mass value="two"/>', "link bob: mass value 'two'; expected a number"),
        ('<mass value="2"/>', '<mass value="-2"/>', "link bob: mass value '-2'; .* at least 0"),
        ('<mass value="2"/>', '<mass value="1e300"/>', "link bob: mass value '1e300'"),
        ('<mass value="2"/>', '<mass value="0"/>', "no link has a mass"),
        ('izz="0"', "", "link bob: inertia izz ''"),
        ('"0 0 -0.5"', '"0 0 -0,5"', "link bob: origin xyz '0 0 -0,5'; expected 3 numbers"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "joint hinge: axis '0 0 0' has no direction"),
        ('<axis xyz="0 1 0"/>', '<origin xyz="0 inf 0"/>', "joint hinge: origin xyz '0 inf 0'"),
        ('"prismatic"', '"planar"', "joint slider: type planar; expected one of revolute"),
        ('child link="bob"', 'child link="nobody"', "joint hinge: child link nobody is not in the file"),
        ('child link="cog"', 'child link="finger"', "link finger: the child of two joints"),
        ('parent link="base"', 'parent link="carriage"', "its joints form a loop"),
        ('<link name="cog"/>', '<link name="cog"/><link name="cog"/>', "2 links of the name cog"),
        ('<link name="cog"/>', '<link name="cog"/><link name="odd"/>', "2 links that are no child of a joint"),
        ('joint name="slider"', 'joint name="hinge"', "2 joints of the name hinge"),
    ],
)  # fmt: skip
def test_a_malformed_urdf_is_refused_by_name(tmp_path: Path, sound: str, wrong: str, message: str) -> None:
    text = PENDULUM.format(kind="revolute")
    assert sound in text
    with pytest.raises(UsageError, match=rf"arm\.urdf: .*{message}"):
        load_arm(write(tmp_path, text.replace(sound, wrong)))


def test_a_chain_without_end_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{n}"/>' for n in range(20_000))
    with pytest.raises(UsageError, match="20000 links; expected at most 1000"):
        load_arm(write(tmp_path, f'<robot name="r">{links}</robot>'))
    with pytest.raises(UsageError, match=r"nowhere\.urdf: No such file"):
        load_arm(tmp_path / "nowhere.urdf")


def test_gravity_direction_explains_what_a_displaced_mass_does() -> None:
    """A point mass in the last link acts on its axis like a constant times the direction of gravity across it."""
    q = np.random.default_rng(3).uniform(-1.0, 1.0, (50, 7))
    error = (load_arm(payload=(1.0, 0.05, 0.02, 0.1)).gravity(q) - ARM.gravity(q))[:, 6]
    assert np.abs(error).max() > 0.3
    assert np.linalg.lstsq(ARM.gravity_direction(q)[:, 6], error, rcond=None)[1][0] < 1e-20


def test_regressor_times_inertial_parameters_of_a_load_is_its_torque() -> None:
    # In the flange frame, which lies 0.107 m in front of the frame of joint 7 and is not turned against it.
    mass, centre, inertia = 2.0, np.array([0.02, -0.01, 0.05]), np.diag([0.1, 0.2, 0.3]) + 0.01
    loaded = ARM.with_load(mass, centre, inertia)
    lever = centre + np.array([0.0, 0.0, 0.107])
    about = inertia + mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    parameters = np.array([mass, *(mass * lever), *about[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
    for joint in range(7):
        entries = np.full(10, joint), np.full(10, 6), np.arange(10)
        extra = loaded.inverse_dynamics(*MOTION) - ARM.inverse_dynamics(*MOTION)
        assert regressor_entries(ARM, MOTION, *entries) @ parameters == pytest.approx(extra[:, joint], abs=1e-10)


def test_regressor_of_a_log_in_another_order() -> None:
    turned = replace(ARM, columns=tuple(range(6, -1, -1)))
    backwards: tuple[Float, Float, Float] = (MOTION[0][:, ::-1], MOTION[1][:, ::-1], MOTION[2][:, ::-1])
    entries = (np.array([5, 2]), np.array([6, 4]), np.array([0, 2]))
    mirrored = (np.array([1, 4]), np.array([0, 2]), np.array([0, 2]))
    assert regressor_entries(turned, backwards, *mirrored) == pytest.approx(regressor_entries(ARM, MOTION, *entries))
    assert tilt_torque(turned, backwards[0]) == pytest.approx(tilt_torque(ARM, MOTION[0])[:, ::-1])


def test_a_tilted_base_to_first_order() -> None:
    tilted = load_arm(gravity_vector=(0.01, 0.02, -9.81))
    across = np.linalg.svd(ARM.model.opt.gravity[None])[2][1:]
    found = tilt_torque(ARM, MOTION[0]) @ (across @ np.array([0.01, 0.02, 0.0]))
    assert found == pytest.approx(tilted.gravity(MOTION[0]) - ARM.gravity(MOTION[0]), abs=1e-9)
