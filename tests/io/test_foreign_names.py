import pytest

from friction_audit.io.readers.channel_names import is_label, labels_of, parse_name, torque_unit


@pytest.mark.parametrize(
    ("name", "channel", "index", "joint"),
    [
        ("q[0]", "q", 0, None),
        (" q[3]", "q", 3, None),
        ("state.q[6]", "q", 6, None),
        ("state.tau_J[6]", "tau_J", 6, None),
        ("cmd.tau_J_d[2]", "tau_J_d", 2, None),
        ("tau_J_d_3", "tau_J_d", 3, None),
        ("tau_J_3", "tau_J", 3, None),
        ("field.position0", "q", 0, None),
        ("field.tau_ext_hat_filtered3", "tau_ext_hat_filtered", 3, None),
        ("position.0", "q", 0, None),
        ("effort.3", "tau_J", 3, None),
        ("q_joint1", "q", 1, "joint1"),
        ("joint1.q", "q", 1, "joint1"),
        ("joint1/dq", "dq", 1, "joint1"),
        ("/joint_states/panda_joint1/position", "q", 1, "panda_joint1"),
        ("/joint_states_desired/panda_joint1/effort", "tau_J_d", 1, "panda_joint1"),
        ("shoulder_pan_joint/position", "q", None, "shoulder_pan_joint"),
        ("tau_J_panda_joint2", "tau_J", 2, "panda_joint2"),
        ("dq1", "dq", 1, None),
        ("motor_torques_measured.3", "tau_J", 3, None),
        ("joint_positions[3]", "q", 3, None),
        ("joint_position_2", "q", 2, None),
        ("measured_joint_state.position[3]", "q", 3, None),
        ("desired_joint_state.effort[1]", "tau_J_d", 1, None),
        ("tau_ext_hat_filtered.effort.0", "tau_ext_hat_filtered", 0, None),
        ("tau_interaction_1", "tau_interaction", 1, None),
        ("F_m", "tau_interaction", None, None),
        ("g_2", "gravity", 2, None),
        ("tau_J_1 [Nm]", "tau_J", 1, None),
        ("temp_1", "temperature", 1, None),
        ("tau_J_ext_1", "tau_ext_hat_filtered", 1, None),
        ("tau_ext_1", "tau_ext_hat_filtered", 1, None),
        ("tau_external_1", "tau_ext_hat_filtered", 1, None),
    ],
)
def test_names_in_use(name: str, channel: str, index: int | None, joint: str | None) -> None:
    parsed = parse_name(name)
    assert parsed is not None
    assert (parsed.channel, parsed.index, parsed.joint) == (channel, index, joint)


@pytest.mark.parametrize(
    "name",
    ["q_d[0]", "cmd.q_d[0]", "dq_d[1]", "ddq_1", "dtau_J_1", "theta_1", "O_F_ext_hat_K[0]", "time", "success rate", "",
     "panda_finger_joint1_position", "measured_joint_motor_state.position[0]", "desired_joint_state.position[1]",
     "observation.state[3]", "sent commands", "elbow[0]"],
)  # fmt: skip
def test_names_of_something_else(name: str) -> None:
    assert parse_name(name) is None


@pytest.mark.parametrize("name", ["q1_deg", "q_1 [deg]", "q_deg_1", "dq_1[deg/s]"])
def test_names_that_say_degrees(name: str) -> None:
    parsed = parse_name(name)
    assert parsed is not None
    assert parsed.degrees
    assert parsed.index == 1


def test_template_shows_where_the_joint_stands() -> None:
    parsed = parse_name("/joint_states/panda_joint4/velocity")
    assert parsed is not None
    assert parsed.template == "/joint_states/panda_joint{i}/velocity"


def test_labels_beside_numbers() -> None:
    assert is_label("field.name3")
    assert is_label("name[0]")
    assert is_label("joint_states.name.10")
    assert not is_label("field.header.frame_id")
    assert not is_label("field.position3")


def test_labels_belong_to_the_columns_of_their_message() -> None:
    names = ["field.name0", "field.name10", "field.position0", "field.position10", "other.position0", "position[0]"]
    labels = labels_of(names[2:], {"field.name0": "elbow", "field.name10": "wrist"})
    assert labels == {0: "elbow", 1: "wrist"}


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("actual_current_{i}", "A"),
        ("target_current", "A"),
        ("joint1.curr", "A"),
        ("i_{i}", "A"),
        ("motorCurrent{i}", "A"),
        ("effort_{i} [A]", "A"),
        ("effort_{i} [mA]", "mA"),
        ("current_torque_{i}", "N m"),
        ("tau_J_{i}", "N m"),
        ("amplitude_{i}", "N m"),
    ],
)
def test_a_column_of_motor_current_is_in_ampere(name: str, unit: str) -> None:
    assert torque_unit(name) == unit
