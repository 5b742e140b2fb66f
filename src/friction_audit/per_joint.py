"""The same work for every joint, several joints at a time.

It pays where the work is in NumPy or in a compiled loop, which give the interpreter away while they run.
"""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

Result = TypeVar("Result")

WORKERS = min(4, os.cpu_count() or 1)
"""Each one needs working memory for a joint of its own."""

_ALONE = ContextVar("_ALONE", default=False)


@contextmanager
def one_joint_at_a_time() -> Iterator[None]:
    """Work through joints one after the other in a block: where logs run side by side, joints need not."""
    token = _ALONE.set(True)
    try:
        yield
    finally:
        _ALONE.reset(token)


def is_alone() -> bool:
    """Return True in a block of ``one_joint_at_a_time``."""
    return _ALONE.get()


def per_joint(work: Callable[[int], Result], joints: int) -> list[Result]:
    """Return the result of the work for each joint (0-based), in order."""
    from threadpoolctl import threadpool_limits

    if is_alone():
        return [work(joint) for joint in range(joints)]
    # Matrices of a joint are tall and narrow: threads inside a product would only wait for each other.
    with (
        threadpool_limits(limits=1, user_api="blas"),
        ThreadPoolExecutor(max_workers=WORKERS, thread_name_prefix="joint") as pool,
    ):
        return list(pool.map(work, range(joints)))
