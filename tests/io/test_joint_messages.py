"""Definitions are matched by their fields."""

from collections.abc import Callable

import pytest

from friction_audit.io.readers.message_kinds import KINDS, match_kind
from friction_audit.joint_log import JOINT_CHANNELS

JOINT_STATE = ("header.stamp", "header.frame_id", "name", "position", "velocity", "effort")
FRANKA = ("header.stamp", "q", "q_d", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered", "time")


def test_joint_state() -> None:
    kind = match_kind(JOINT_STATE)
    assert kind is not None
    assert kind.fields == {"q": "position", "dq": "velocity", "tau_J": "effort"}
    assert (kind.names, kind.robot_time, kind.stamps) == ("name", None, ("header.stamp",))


@pytest.mark.parametrize("fold", [str, str.lower], ids=["ROS 1", "ROS 2"])
def test_franka_state_in_either_spelling(fold: Callable[[str], str]) -> None:
    kind = match_kind([fold(path) for path in FRANKA])
    assert kind is not None
    assert kind.fields["tau_J"] == fold("tau_J")
    assert kind.fields["tau_J_d"] == fold("tau_J_d")
    assert kind.robot_time == "time"


def test_desired_values_of_a_controller_state_are_not_taken_for_measured() -> None:
    assert match_kind(["header.stamp", "joint_names", "desired.positions", "actual.positions"]) is None


def test_pose_is_no_joint_state() -> None:
    assert match_kind(["header.stamp", "position.x", "orientation.w"]) is None


def test_channels_are_those_of_a_joint_log() -> None:
    assert all(set(kind.fields) <= set(JOINT_CHANNELS) for kind in KINDS)
