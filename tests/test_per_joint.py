import pytest

from friction_audit.per_joint import per_joint


def test_results_come_in_the_order_of_the_joints() -> None:
    assert per_joint(lambda joint: 10 * joint, 7) == [0, 10, 20, 30, 40, 50, 60]


def test_an_error_at_one_joint_is_raised() -> None:
    def work(joint: int) -> float:
        return 1.0 / (joint - 3)

    with pytest.raises(ZeroDivisionError):
        per_joint(work, 7)
