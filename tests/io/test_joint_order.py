"""Arms, their joints and the robot, from names alone."""

import pytest

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers.joint_names import arms_in, choose_arm, robot_of

PANDA = tuple(f"panda_joint{i}" for i in range(1, 8))


def test_scrambled_with_fingers() -> None:
    names = ("panda_finger_joint1", *PANDA[::-1], "panda_finger_joint2")
    assert arms_in(names) == {"panda": PANDA}


def test_nine_joints_are_sorted_by_number_not_by_text() -> None:
    names = [f"joint{i}" for i in (10, 9, 1, 2, 3, 4, 5, 6, 7, 8)]
    assert arms_in(names) == {"": tuple(f"joint{i}" for i in range(1, 11))}


def test_two_arms() -> None:
    names = [f"{side}_fr3_joint{i}" for i in (2, 1) for side in ("right", "left")]
    expected = {side: (f"{side}_joint1", f"{side}_joint2") for side in ("left_fr3", "right_fr3")}
    assert arms_in(names) == expected


def test_lift_beside_an_arm_is_no_arm() -> None:
    assert arms_in(["lift_joint1", *PANDA, "wheel_left"]) == {"panda": PANDA}


def test_names_without_numbers_keep_their_order() -> None:
    assert arms_in(["shoulder", "elbow", "left_finger"]) == {"": ("shoulder", "elbow")}


def test_joints_may_count_from_zero() -> None:
    assert arms_in(["joint2", "joint0", "joint1"]) == {"": ("joint0", "joint1", "joint2")}


def test_two_robots_are_none() -> None:
    assert robot_of(("panda_joint1", "fr3_joint1")) == "unknown"


def test_the_arm_of_a_table_is_chosen_as_in_a_bag() -> None:
    names = [f"{side}_joint{i}" for side in ("left", "right") for i in (2, 1)]
    assert choose_arm(PANDA[::-1], "", path="log") == PANDA
    assert choose_arm(names, "right", path="log") == ("right_joint1", "right_joint2")
    with pytest.raises(
        UsageError, match="several arms in one log; choose one with --topic '#left' or --topic '#right'"
    ):
        choose_arm(names, "", path="log")
    with pytest.raises(InputError, match="no arm 'middle' in this table; it has left, right"):
        choose_arm(names, "middle", path="log")


def test_names_that_differ_in_their_last_number_are_sorted_by_it() -> None:
    assert arms_in(["lbr_A10", "lbr_A2", "lbr_A1"]) == {"": ("lbr_A1", "lbr_A2", "lbr_A10")}
    assert arms_in(["3", "0", "12"]) == {"": ("0", "3", "12")}
    assert arms_in(["shoulder2", "elbow1"]) == {"": ("shoulder2", "elbow1")}


def test_only_fingers() -> None:
    assert arms_in(["panda_finger_joint1", "panda_finger_joint2"]) == {}


@pytest.mark.parametrize(
    ("prefix", "robot"),
    [
        ("panda_", "panda"),
        ("fer_", "panda"),
        ("panda_1_", "panda"),
        ("panda1_", "panda"),
        ("Panda_", "panda"),
        ("left/panda_", "panda"),
        ("left_fer_", "panda"),
        ("left_fr3_", "fr3"),
        ("left_panda_", "panda"),
        ("fr3_", "fr3"),
        ("right_fr3_", "fr3"),
        ("fr3v2_", "fr3"),
        ("iiwa_", "unknown"),
        ("transfer_", "unknown"),
        ("", "unknown"),
    ],
)
def test_robot(prefix: str, robot: str) -> None:
    assert robot_of([f"{prefix}joint{i}" for i in range(1, 8)]) == robot


def test_the_joints_of_a_gripper_are_no_second_arm() -> None:
    assert arms_in(["gripper_joint_1", "gripper_joint_2", "joint_2", "joint_1"]) == {"": ("joint_1", "joint_2")}
    assert arms_in(["A2", "A1", "left_gripper"]) == {"": ("A1", "A2")}
