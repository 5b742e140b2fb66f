import threading

import numpy as np  # noqa: F401 - brings the library whose threads are counted
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from friction_audit.parallel import one_joint_at_a_time, per_joint


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
