import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.errors import UsageError
from friction_audit.joint_numbers import parse_joint_numbers, require_joints, split_joints, write_joint_numbers


@given(st.sets(st.integers(1, 40), min_size=1))
def test_what_is_written_reads_back(joints: set[int]) -> None:
    assert parse_joint_numbers(write_joint_numbers(sorted(joints)), "here") == tuple(sorted(joints))


def test_runs_are_written_short() -> None:
    assert write_joint_numbers((1, 3, 4, 5, 7)) == "1,3-5,7"


def test_joints_stand_behind_the_at_sign() -> None:
    assert split_joints("stribeck:excess_nm=0.2@2,5", "here") == ("stribeck:excess_nm=0.2", (2, 5))
    assert split_joints("stribeck", "here") == ("stribeck", None)
    with pytest.raises(UsageError, match=r"^here: '' is no joint"):
        split_joints("stribeck@", "here")


def test_all_joints_that_are_not_there_are_named() -> None:
    require_joints((1, 7), 7, "here")
    with pytest.raises(UsageError, match=r"^here: no joint 8-9; expected joints from 1 to 7$"):
        require_joints((2, 8, 9), 7, "here")
    with pytest.raises(UsageError, match="there is only joint 1"):
        require_joints((2,), 1, "here")
