import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.errors import InputError
from friction_audit.io.readers.columns import map_columns
from friction_audit.io.readers.reader import SeveralArmsError


def numbered(template: str, first: int, joints: int) -> list[str]:
    return [template.format(i) for i in range(first, first + joints)]


def test_tidy_columns_count_from_one() -> None:
    names = ["time", *numbered("q_{}", 1, 3), *numbered("dq_{}", 1, 3), *numbered("tau_J_{}", 1, 3)]
    columns = map_columns(names, path="log", mapping={})
    assert columns.channels == {"q": (1, 2, 3), "dq": (4, 5, 6), "tau_J": (7, 8, 9)}
    assert columns.joint_names == ("joint1", "joint2", "joint3")
    assert columns.mapping["dq"] == "dq_{i}"
    assert columns.time.cells == (0,)


@given(st.integers(1, 12), st.sampled_from([0, 1]), st.randoms())
def test_any_number_of_joints_in_any_order(joints: int, first: int, random: object) -> None:
    names = ["t", *(f"{c}{i}" for c in ("q", "dq", "tau_J") for i in range(first, first + joints))]
    shuffled = list(names)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    columns = map_columns(shuffled, path="log", mapping={})
    for channel in ("q", "dq", "tau_J"):
        assert [shuffled[cell] for cell in columns.channels[channel]] == numbered(channel + "{}", first, joints)


def test_old_libfranka_header_takes_the_first_of_repeated_names() -> None:
    state = [f" {c}[{i}]" for c in ("q", "q_d", "dq", "dq_d", "tau_J", "tau_ext_hat_filtered") for i in range(7)]
    command = [f" {c}[{i}]" for c in ("q_d", "dq_d", "tau_J_d") for i in range(7)]
    names = ["duration", " success rate", *state, "sent commands", *command]
    columns = map_columns(names, path="log", mapping={})
    assert columns.channels["q"] == tuple(range(2, 9))
    assert columns.channels["tau_J_d"] == tuple(range(len(names) - 7, len(names)))
    assert (columns.time.unit, columns.time.clock) == ("ms", "robot_time")


def test_joint_names_tell_the_robot_and_fingers_are_left_out() -> None:
    joints = [*numbered("fr3_joint{}", 1, 7), "fr3_finger_joint1"]
    names = [
        "__time",
        *(f"/joint_states/{j}/{c}" for c in ("position", "velocity", "effort") for j in reversed(joints)),
    ]
    columns = map_columns(names, path="log", mapping={})
    assert columns.joint_names == tuple(numbered("fr3_joint{}", 1, 7))
    assert columns.robot == "fr3"


def test_labels_beside_numbers_leave_fingers_out() -> None:
    names = ["%time", *(f"field.{c}{i}" for c in ("position", "velocity", "effort") for i in range(3))]
    joints = ("panda_finger_joint1", "panda_joint1", "panda_joint2")
    columns = map_columns(names, path="log", mapping={}, labels=dict(enumerate(3 * joints, start=1)))
    assert columns.joint_names == ("panda_joint1", "panda_joint2")
    assert columns.channels["q"] == (2, 3)
    assert (columns.time.unit, columns.time.clock) == ("ns", "log_time")


def test_one_joint_without_a_number() -> None:
    columns = map_columns(["t", "q", "dq", "F_m"], path="log", mapping={})
    assert columns.channels == {"q": (1,), "dq": (2,), "tau_interaction": (3,)}


def test_libfranka_names_win_over_general_ones() -> None:
    names = ["time", "q_1", "position_1", "dq_1", "velocity_1", "effort_1", "tau_J_1"]
    assert map_columns(names, path="log", mapping={}).channels == {"q": (1,), "dq": (3,), "tau_J": (6,)}


def test_two_arms_are_refused_by_name() -> None:
    names = [
        "time",
        *(f"{arm}_joint{i}/{c}" for arm in ("left", "right") for c in ("q", "dq", "tau_J") for i in (1, 2)),
    ]
    with pytest.raises(SeveralArmsError, match=r"several arms for q: left_joint\{i\}/q, right_joint\{i\}/q"):
        map_columns(names, path="log", mapping={})


def test_two_arms_are_chosen_by_mapping() -> None:
    names = [
        "time",
        *(f"{arm}_joint{i}/{c}" for arm in ("left", "right") for c in ("q", "dq", "tau_J") for i in (1, 2)),
    ]
    mapping = {c: f"right_joint{{i}}/{c}" for c in ("q", "dq", "tau_J")}
    assert map_columns(names, path="log", mapping=mapping).channels["q"] == (7, 8)


def test_mapping_wins_over_guesses() -> None:
    names = ["time", "q_1", "dq_1", "dq_filtered_1", "tau_J_1"]
    assert map_columns(names, path="log", mapping={"dq": "dq_filtered_{i}"}).channels["dq"] == (3,)


def test_mapping_by_list_number_and_unit() -> None:
    names = [f"#{i}" for i in range(1, 8)]
    mapping = {"t": "#1:ms", "q": "#2-#3", "dq": "#4,#5", "tau_J": "#6-7"}
    columns = map_columns(names, path="log", mapping=mapping)
    assert columns.channels == {"q": (1, 2), "dq": (3, 4), "tau_J": (5, 6)}
    assert columns.time.unit == "ms"


def test_mapping_names_a_list_column() -> None:
    names = ["time", "a[0]", "a[1]", "b[0]", "b[1]", "c[0]", "c[1]"]
    columns = map_columns(names, path="log", mapping={"q": "a", "dq": "b", "tau_J": "c"})
    assert columns.channels == {"q": (1, 2), "dq": (3, 4), "tau_J": (5, 6)}


def test_all_missing_columns_at_once_with_near_misses() -> None:
    names = ["tyme", *numbered("velocty_{}", 1, 7), *numbered("q_{}", 1, 7)]
    with pytest.raises(InputError) as caught:
        map_columns(names, path="log", mapping={})
    message = str(caught.value)
    assert "no column for t and dq and a torque (tau_interaction, tau_J, tau_ext_hat_filtered)" in message
    assert "tyme (t), velocty_1 (dq)" in message
    assert "--map dq=<column with {i} for the joint>" in message
    assert "dq is not made from q" in message
    assert "velocty_1...velocty_7" in message


def test_a_mapped_column_that_is_not_there() -> None:
    names = ["time", "q_1", "dq_1", "tau_J_1"]
    with pytest.raises(InputError, match=r"no column for --map tau_J=.*did you mean .*tau_J_1"):
        map_columns(names, path="log", mapping={"tau_J": "tau_1"})
    with pytest.raises(InputError, match="no column for --map tau_J=tauJ_"):
        map_columns(names, path="log", mapping={"tau_J": "tauJ_{i}"})


def test_joints_that_do_not_match() -> None:
    names = ["time", "q_1", "q_2", "dq_1", "dq_2", "tau_J_1"]
    with pytest.raises(InputError, match=r"expected 2 joints: 1, 2 as in q_\{i\}, but tau_J \(1 joint: 1\)"):
        map_columns(names, path="log", mapping={})


def test_an_incomplete_channel_that_is_not_needed_is_left_out() -> None:
    names = ["time", "q_1", "q_2", "dq_1", "dq_2", "tau_J_1", "tau_J_2", "temperature_1"]
    columns = map_columns(names, path="log", mapping={})
    assert "temperature" not in columns.channels
    assert [finding.code for finding in columns.findings] == ["incomplete_channel"]
