import threading

import numpy as np  # noqa: F401 - brings the library whose threads are counted
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from friction_audit.per_joint import WORKERS, one_joint_at_a_time, per_joint, side_by_side


def test_results_come_in_the_order_of_the_joints() -> None:
    assert per_joint(lambda joint: 10 * joint, 7) == [0, 10, 20, 30, 40, 50, 60]


def test_an_error_at_one_joint_is_raised() -> None:
    def work(joint: int) -> float:
        return 1.0 / (joint - 3)

    with pytest.raises(ZeroDivisionError):
        per_joint(work, 7)


def test_one_joint_at_a_time_takes_no_threads() -> None:
    with one_joint_at_a_time():
        assert per_joint(lambda joint: (joint, threading.get_ident()), 3) == [
            (j, threading.get_ident()) for j in range(3)
        ]
    assert threading.get_ident() not in per_joint(lambda _: threading.get_ident(), 3)


def test_products_of_matrices_take_one_thread_meanwhile() -> None:
    def threads(_: int = 0) -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    with threadpool_limits(limits=2, user_api="blas"):
        assert threads() == {2}
        assert per_joint(threads, 2) == [{1}, {1}]
        assert threads() == {2}


def test_parts_come_in_their_order_with_and_without_other_workers() -> None:
    assert side_by_side(lambda part: 10 * part, range(5)) == [0, 10, 20, 30, 40]
    assert per_joint(lambda joint: side_by_side(lambda part: joint * part, range(5)), 3) == [
        [joint * part for part in range(5)] for joint in range(3)
    ]
    assert side_by_side(lambda part: 10 * part, []) == []


def test_a_worker_without_a_joint_takes_parts() -> None:
    both = threading.Barrier(2, timeout=60.0)

    def part(_: int) -> int:
        both.wait()  # gives up unless two parts are being done at once
        return threading.get_ident()

    if WORKERS > 1:
        (threads,) = per_joint(lambda _: side_by_side(part, range(2)), 1)
        assert len(set(threads)) == 2


@pytest.mark.parametrize("joints", [1, 7])
def test_an_error_in_a_part_is_raised(joints: int) -> None:
    with pytest.raises(ZeroDivisionError):
        per_joint(lambda _: side_by_side(lambda part: 1 / (part - 3), range(7)), joints)
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda part: 1 / (part - 3), range(7))
