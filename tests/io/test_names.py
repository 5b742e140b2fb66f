"""What names say: of columns the channel, of joints arm and robot, of message fields the kind, of logs their arm."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from hypothesis import given, strategies as st

from friction_audit.errors import InputError
from friction_audit.io.readers import arm_of_log, read_log
from friction_audit.io.readers.arrays import ArrayTable
from friction_audit.io.readers.channel_names import arms_in, parse_name, robot_of, torque_unit
from friction_audit.io.readers.columns import ColumnMap, map_columns
from friction_audit.io.readers.joint_states import kind_of
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import Source
from tests.io.bag_writing import joint_states, ros2_store, samples, write
from tests.io.synthetic_recordings import refused

PANDA = tuple(f"panda_joint{i}" for i in range(1, 8))
TWO_ARMS = ["time", *(f"{a}_joint{i}/{c}" for a in ("left", "right") for c in ("q", "dq", "tau_J") for i in (1, 2))]


NAMES = {
    ("q", 0, None): "q[0]|state.q[0]|field.position0|position.0|axisQMsr_LBR_iiwa_7_R800_1[0]",
    ("q", 3, None): (
        " q[3]|joint_positions[3]|measured_joint_state.position[3]|data.qpos.3|obs/joint_pos[3]"
        "|Axis3_FeedbackPosition|/friction_test/joint_states/position[3]"
    ),
    ("q", 2, None): "joint_position_2",
    ("q", 1, "joint1"): "q_joint1|joint1.q",
    ("q", 1, "panda_joint1"): "/joint_states/panda_joint1/position",
    ("q", None, "shoulder_pan_joint"): "shoulder_pan_joint/position|shoulder_pan_joint_position",
    ("dq", 1, None): (
        "dq1|dq_1[deg/s]|actuator_1_velocity_deg|q_dot_1|qDot1|position_dot_1|iiwa.joint_velocity_estimated[1]"
    ),
    ("dq", 1, "joint1"): "joint1/dq",
    ("tau_J", 3, None): (
        "state.tau_J[3]|tau_J_3|effort.3|motor_torques_measured.3|MeasuredTorque_A3|motor_3_tau_est"
        "|measured_tq_3|joint_effort_3|J3 Trq (Nm)|Feedback trq 3|lowstate.motor_state[3].tauEst"
        "|/panda/tau_measured.3|axisTauMsr_LBR_iiwa_14_R820_1[3]|iq_3 [A]"
    ),
    ("tau_J", 1, None): "tau_J_1 [Nm]",
    ("tau_J", 2, "panda_joint2"): "tau_J_panda_joint2",
    ("tau_J_d", 2, None): "cmd.tau_J_d[2]|tau_J_d_2|desired_joint_state.effort[2]",
    ("tau_J_d", 1, "panda_joint1"): "/joint_states_desired/panda_joint1/effort",
    ("tau_ext_hat_filtered", 1, None): "field.tau_ext_hat_filtered1|tau_ext_1|tau_external_1|tau_J_ext_1",
    ("tau_ext_hat_filtered", 0, None): "tau_ext_hat_filtered.effort.0|axisTauExtMsr_LBR_iiwa_7_R800_1[0]",
    ("tau_interaction", 1, None): "tau_interaction_1",
    ("tau_interaction", None, None): "F_m",
    ("gravity", 2, None): "g_2",
    ("temperature", 1, None): "temp_1",
    ("q", 1, None): (
        "MeasuredJointPosition_A1|Joint 1 Position [rad]|J1 Pos|motor_1_q|actual_position_1"
        "|current_position_1|q1_deg|q_1 [deg]|q_deg_1|q(1)|x.q (1) (rad)|lowstate.motor_state[1].q"
        "|base_feedback.actuators.1.position|link_position_1|q1 [rad]|actuators_1_position"
    ),
    ("dq", 2, None): "qDot2|dqm2|Joint 2 Velocity [rad/s]|jointVel2",
    ("tau_ext_hat_filtered", 3, None): "ExternalTorque_A3|external_joint_torque_3",
    ("tau_J_d", 1, None): "desired_torque_1",
    ("tau_J", None, "arm_1_joint"): "- arm_1_joint_effort",
}


@pytest.mark.parametrize(("expected", "names"), NAMES.items(), ids=list(map(str, NAMES)))
def test_names_of_columns_in_use(expected: tuple[str, int | None, str | None], names: str) -> None:
    for name in names.split("|"):
        parsed = parse_name(name)
        assert parsed is not None
        assert (parsed.channel, parsed.index, parsed.joint) == expected
        assert parsed.degrees is ("deg" in name)


@pytest.mark.parametrize(
    "name",
    ["q_d[0]", "cmd.q_d[0]", "dq_d[1]", "ddq_1", "dtau_J_1", "theta_1", "O_F_ext_hat_K[0]", "time", "success rate", "",
     "panda_finger_joint1_position", "measured_joint_motor_state.position[0]", "desired_joint_state.position[1]",
     "observation.state[3]", "sent commands", "elbow[0]", "friction_torque_1",
     "qd_1", "target_q_1", "target_current_1", "target_moment_1",
     "tau_J_dot_1", "dq_dot_1", "q_dot_dot_1", "qDotDot1", "current_dot_1", "q(:,1)", "tau(1,2)",
     "tcp/position[0]", "ee/pos_0", "state.pose.position[1]", "wrench.torque[2]", "imu.angular_velocity[0]",
     "tool.velocity.0", "friction.torque[0]", "position_errors/q_0", "limits.position[0]", "ddq.velocity[0]",
     "planned.positions[0]", "trajectory.points[0].positions[1]", "actions.joint_position_0", "setpoints/velocity[0]",
     "command.effort[0]", "lowcmd.motor_cmd[0].tau", "iiwa_position_commanded_1", "robot0_joint_acc_0",
     "qfrc_bias_0", "target_qdd_0", "joint_position_ipo[0]",
     "q_1 [mrad]", "dq_1 [rev/s]", "tau_1 [mNm]", "torque_1 (kgf.cm)", "tau_1 [N]",
     "tau_measured_compensate1", "cartesian_position_0", "gravity_compensation_torque_1", "d_tau_1"],
)  # fmt: skip
def test_names_of_something_else(name: str) -> None:
    assert parse_name(name) is None


@pytest.mark.parametrize(
    ("unit", "names"),
    [
        ("A", "actual_current_{i}|target_current|joint1.curr|i_{i}|motorCurrent{i}|effort_{i} [A]|iq_{i}|#14-#19:A"),
        ("mA", "effort_{i} [mA]|load_{i}:mA"),
        ("N m", "current_torque_{i}|tau_J_{i}|amplitude_{i}"),
    ],
)
def test_a_column_of_motor_current_is_in_ampere(unit: str, names: str) -> None:
    assert {torque_unit(name) for name in names.split("|")} == {unit}


@pytest.mark.parametrize(
    ("names", "arms"),
    [
        (["panda_finger_joint1", *PANDA[::-1], "panda_finger_joint2"], {"panda": PANDA}),
        ([f"joint{i}" for i in (10, 9, 1, 2, 3)], {"": ("joint1", "joint2", "joint3", "joint9", "joint10")}),
        (["r_fr3_joint2", "l_fr3_joint1", "r_fr3_joint1", "l_fr3_joint2"],
         {"l_fr3": ("l_fr3_joint1", "l_fr3_joint2"), "r_fr3": ("r_fr3_joint1", "r_fr3_joint2")}),
        (["lift_joint1", *PANDA, "wheel_left"], {"panda": PANDA}),
        (["shoulder", "elbow", "left_finger"], {"": ("shoulder", "elbow")}),
        (["joint2", "joint0", "joint1"], {"": ("joint0", "joint1", "joint2")}),
        (["lbr_A10", "lbr_A2", "lbr_A1"], {"": ("lbr_A1", "lbr_A2", "lbr_A10")}),
        (["3", "0", "12"], {"": ("0", "3", "12")}),
        (["shoulder2", "elbow1"], {"": ("shoulder2", "elbow1")}),
        (["panda_finger_joint1", "panda_finger_joint2"], {}),
        (["gripper_joint_1", "gripper_joint_2", "joint_2", "joint_1"], {"": ("joint_1", "joint_2")}),
        (["A2", "A1", "left_gripper"], {"": ("A1", "A2")}),
    ],
)  # fmt: skip
def test_arms_and_the_order_of_their_joints(names: Sequence[str], arms: Mapping[str, tuple[str, ...]]) -> None:
    assert arms_in(names) == arms


@pytest.mark.parametrize(
    ("robot", "prefixes"),
    [
        ("panda", ["panda_", "fer_", "panda_1_", "panda1_", "Panda_", "left/panda_", "left_fer_", "left_panda_"]),
        ("fr3", ["left_fr3_", "fr3_", "right_fr3_", "fr3v2_"]),
        ("unknown", ["iiwa_", "transfer_", ""]),
    ],
)
def test_robot_by_the_prefix_of_its_joints(robot: str, prefixes: Sequence[str]) -> None:
    assert {robot_of([f"{prefix}joint{i}" for i in range(1, 8)]) for prefix in prefixes} == {robot}
    assert robot_of(("panda_joint1", "fr3_joint1")) == "unknown"


def mapped(names: str | Sequence[str], **mapping: str) -> ColumnMap:
    table = ArrayTable(Path("log"), {})
    table.names = names.split() if isinstance(names, str) else names
    return map_columns(table, mapping, "")


def test_the_joint_comes_before_its_motor_and_the_degree_sign_is_read() -> None:
    both = [f"{side}_{c}_1" for side in ("motor", "link") for c in ("position", "velocity", "torque")]
    assert {name.split("_")[0] for name in mapped(["t", *both]).mapping.values()} == {"link"}
    assert mapped(["t", "q1 [°]", "dq1 [°/s]", "tau1 [Nm]"]).per_turn == {"q": 360.0, "dq": 360.0}


def test_a_torque_from_elsewhere_than_the_position_is_doubted() -> None:
    apart = mapped("t left.q1 left.q2 left.dq1 left.dq2 right.tau1 right.tau2")
    assert [finding.code for finding in apart.findings] == ["topic_chosen"]
    assert mapped("t left.q1 left.q2 left.dq1 left.dq2 left.tau1 left.tau2").findings == ()


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("msg_id q1 dq1 tau1", "no column for t; .*--map t=msg_id:ms"),
        ("t mp1 mp2 mt1 mt2", r"mp1...mp2 \(#2-#3\).*--map q=.*--map dq=.*--map tau_J=.*#2-#8"),
        ("t q1 dq1 tau1[mNm]", r"tau1\[mNm\]: expected rad or deg.*--torque-scale"),
    ],
)
def test_a_refusal_leads_to_the_right_map(names: str, words: str) -> None:
    refused(words, mapped, names)


@given(st.integers(1, 12), st.sampled_from([0, 1]), st.randoms())
def test_any_number_of_joints_in_any_order(joints: int, first: int, random: object) -> None:
    names = ["t", *(f"{c}{i}" for c in ("q", "dq", "tau_J") for i in range(first, first + joints))]
    shuffled = list(names)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    columns = mapped(shuffled)
    for channel in ("q", "dq", "tau_J"):
        expected = [f"{channel}{i}" for i in range(first, first + joints)]
        assert [shuffled[cell] for cell in columns.channels[channel]] == expected


@pytest.mark.parametrize(
    ("names", "mapping", "channels"),
    [
        ("t q dq F_m", {}, {"q": (1,), "dq": (2,), "tau_interaction": (3,)}),
        ("time q_1 position_1 dq_1 velocity_1 effort_1 tau_J_1", {}, {"q": (1,), "dq": (3,), "tau_J": (6,)}),
        ("time q_1 dq_1 dq_filtered_1 tau_J_1", {"dq": "dq_filtered_{i}"}, {"q": (1,), "dq": (3,), "tau_J": (4,)}),
        ("#1 #2 #3 #4 #5 #6 #7", {"t": "#1:ms", "q": "#2-#3", "dq": "#4,#5", "tau_J": "#6-7"},
         {"q": (1, 2), "dq": (3, 4), "tau_J": (5, 6)}),
        ("time a[0] a[1] b[0] b[1] c[0] c[1]", {"q": "a", "dq": "b", "tau_J": "c"},
         {"q": (1, 2), "dq": (3, 4), "tau_J": (5, 6)}),
        (TWO_ARMS, {c: f"right_joint{{i}}/{c}" for c in ("q", "dq", "tau_J")},
         {"q": (7, 8), "dq": (9, 10), "tau_J": (11, 12)}),
    ],
)  # fmt: skip
def test_columns_of_channels(
    names: str | Sequence[str], mapping: Mapping[str, str], channels: Mapping[str, tuple[int, ...]]
) -> None:
    columns = mapped(names, **mapping)
    assert columns.channels == channels
    assert columns.time.unit == ("ms" if "t" in mapping else None)


def test_position_and_torque_are_of_one_arm_and_of_the_joints() -> None:
    """Of a leader and a follower, of motor and joint."""
    arms = [f"{name}.{i}" for name in ("leader.qpos", "follower.qpos", "follower.effort") for i in range(3)]
    assert mapped(["t", *arms]).mapping == {"q": "follower.qpos.{i}", "tau_J": "follower.effort.{i}"}
    sides = [f"{side}_{what}" for side in ("motor", "joint") for what in ("position", "torque")]
    assert mapped(["t", *sides]).mapping == {"q": "joint_position", "tau_J": "joint_torque"}
    for paths in ("leader.position follower.position follower.effort", "motor.q follower.q follower.tau"):
        kind = kind_of(paths.split())
        assert kind is not None
        assert all(path.startswith("follower") for path in kind.fields.values())
    both = [f"/{arm}/{what}[{i}]" for arm in ("left", "right") for what in ("position", "effort") for i in range(3)]
    columns = mapped(["t", *both])
    assert {template[:5] for template in columns.mapping.values()} == {"/left"}
    assert [finding.code for finding in columns.findings] == ["topic_chosen"]
    with pytest.raises(InputError, match=r"several columns may be q; .* --map q=pan.pos,lift.pos"):
        mapped("t pan.pos lift.pos pan.effort lift.effort")


def test_columns_that_are_not_there() -> None:
    refused("no column for --map tau_J=tauJ_", mapped, "time q_1 dq_1 tau_J_1", tau_J="tauJ_{i}")
    columns = mapped("time q_1 q_2 dq_1 dq_2 tau_J_1 tau_J_2 temperature_1")
    assert "temperature" not in columns.channels
    assert [finding.code for finding in columns.findings] == ["incomplete_channel"]
    assert mapped("time q_1 q_2 dq_1 dq_2 tau_J_1 tau_J_2 temperature").channels["temperature"] == (7, 7)
    message = mapped("time q_2 q_3 dq_2 dq_3 tau_J_1 tau_J_2 tau_J_3").findings[0].message
    assert message == "tau_J_1 left out: q_{i} has no such joint"


@pytest.mark.parametrize(
    ("paths", "fields"),
    [
        ("joint_names desired.positions actual.positions", None),  # commands
        ("position.x orientation.w", None),  # a pose
        ("commanded_torque external_torque ipo_joint_position measured_joint_position measured_torque",  # KUKA LBRState
         {"q": "measured_joint_position", "tau_J": "measured_torque", "tau_ext_hat_filtered": "external_torque"}),
        ("tick motor_state[].q motor_state[].ddq motor_state[].dq motor_state[].tau_est",  # Unitree LowState
         {"q": "motor_state[].q", "dq": "motor_state[].dq", "tau_J": "motor_state[].tau_est"}),
        ("joint_names error.positions desired.positions actual.positions actual.velocities actual.effort error.effort",
         {"q": "actual.positions", "dq": "actual.velocities", "tau_J": "actual.effort"}),
    ],
)  # fmt: skip
def test_other_messages_by_the_names_of_their_fields(paths: str, fields: dict[str, str] | None) -> None:
    kind = kind_of(["header.stamp", *paths.split()])
    assert (kind and kind.fields) == fields
    assert kind is None or kind.names == ("joint_names" if "joint_names" in paths else None)


ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "sample_logs" / "formats"


@pytest.mark.parametrize(
    ("topic", "joints", "name"),
    [
        (None, "joint", ""),
        (None, "panda_joint", ""),
        (None, "fr3v2_joint", ""),
        (None, "left_joint", "left"),
        (None, "panda_2_joint", "panda_2"),
        ("/joint_states", "panda_joint", ""),
        ("/left/joint_states", "panda_joint", "left"),
        ("/cell/left/franka_state_controller/franka_states", "panda_joint", "cell/left"),
        ("/franka_state_controller/franka_states", "panda_joint", ""),
        ("/left/joint_states", "right_joint", "right"),
    ],
)
def test_serial_numbers_before_names_before_namespaces(topic: str | None, joints: str, name: str) -> None:
    source = Source(path="x", sha256="0", format="csv", topic=topic)
    assert arm_of_log(source, [f"{joints}1", f"{joints}2"]) == name
    assert arm_of_log(replace(source, serial="295341-1324"), [f"{joints}1"]) == "295341-1324"


def test_parquet_keeps_serial_number_and_start(tmp_path: Path) -> None:
    log = read_log(SAMPLES / "parquet.parquet")
    marked = replace(log, source=replace(log.source, serial="295341", start_s=1.77e9))
    write_log(marked, tmp_path / "a.parquet")
    again = read_log(tmp_path / "a.parquet").source
    assert (again.serial, again.start_s) == ("295341", 1.77e9)
    table = pq.read_table(tmp_path / "a.parquet")
    pq.write_table(table.replace_schema_metadata({"start_s": "soon"}), tmp_path / "b.parquet")
    other = read_log(tmp_path / "b.parquet").source
    assert (other.serial, other.start_s) == ("", None)


def test_serial_numbers_in_the_metadata_of_mcap_and_in_the_custom_data_of_a_bag(tmp_path: Path) -> None:
    streams = [joint_states(ros2_store(), samples(20))]
    for chunked in (True, False):
        path = tmp_path / f"{chunked}.mcap"
        notes = {"Serial-Number" if chunked else "robot serial": " 295341 ", "serial": "", "port": "serial"}
        write(path, streams, notes=notes, use_chunking=chunked)
        assert read_log(path).source.serial == "295341"
    bag = shutil.copytree(SAMPLES / "rosbag2-sqlite3", tmp_path / "run")
    assert read_log(bag).source.serial == ""
    with (bag / "metadata.yaml").open("a") as stream:
        stream.write("  custom_data:\n    serial: '295341'\n    operator: Ann\n")
    assert read_log(bag).source.serial == "295341"
