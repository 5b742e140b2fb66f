"""The same work for every joint, several joints at a time; and parts of it, where no joint is waiting for a core.

It pays where the work is in NumPy or in a compiled loop, which give the interpreter away while they run.
"""

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import Generic, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

WORKERS = min(4, os.cpu_count() or 1)
"""Each one needs working memory for a joint of its own."""

_ALONE = ContextVar("_ALONE", default=False)
_POOL: ContextVar[ThreadPoolExecutor | None] = ContextVar("_POOL", default=None)


@contextmanager
def one_joint_at_a_time() -> Iterator[None]:
    """Work through joints one after the other in a block: where logs run side by side, joints need not."""
    token = _ALONE.set(True)
    try:
        yield
    finally:
        _ALONE.reset(token)


def per_joint(work: Callable[[int], Result], joints: int) -> list[Result]:
    """Return the result of the work for each joint (0-based), in order."""
    from threadpoolctl import threadpool_limits

    if _ALONE.get():
        return [work(joint) for joint in range(joints)]
    # Matrices of a joint are tall and narrow: threads inside a product would only wait for each other.
    with (
        threadpool_limits(limits=1, user_api="blas"),
        ThreadPoolExecutor(max_workers=WORKERS, thread_name_prefix="joint") as pool,
    ):

        def one(joint: int) -> Result:
            _POOL.set(pool)
            return work(joint)

        return list(pool.map(one, range(joints)))


def side_by_side(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Return the result of the work for each part of what one joint asks for, in order.

    Within ``per_joint`` workers without a joint take parts too; elsewhere they come one after the other.
    """
    parts, pool = _Parts(work, items), _POOL.get()
    # Joints are in the queue before any of these, so that no joint waits for another one's parts.
    helpers = [] if pool is None else [pool.submit(copy_context().run, parts.take) for _ in items[1:WORKERS]]
    try:
        parts.take()
    finally:
        parts.left.clear()
        begun = [helper for helper in helpers if not helper.cancel()]
        errors = [error for helper in begun if (error := helper.exception()) is not None]
    if errors:
        raise errors[0]
    return [parts.done.pop(place) for place in range(len(items))]


class _Parts(Generic[Item, Result]):
    """Parts that are left to do, what has come of the others, by place; empty in the end, for a queue may keep it."""

    def __init__(self, work: Callable[[Item], Result], items: Sequence[Item]) -> None:
        self.left = deque((place, work, item) for place, item in enumerate(items))
        self.done: dict[int, Result] = {}

    def take(self) -> None:
        """Do one part after the other until none is left."""
        while True:
            try:
                place, work, item = self.left.popleft()
            except IndexError:
                return
            self.done[place] = work(item)
