"""The same work for every joint, several joints at a time.

It pays where the work is in NumPy or in a compiled loop, which give the interpreter away while they run.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Result = TypeVar("Result")

WORKERS = min(4, os.cpu_count() or 1)
"""Each one needs working memory for a joint of its own."""


def per_joint(work: Callable[[int], Result], joints: int) -> list[Result]:
    """Return the result of the work for each joint (0-based), in order."""
    with ThreadPoolExecutor(max_workers=WORKERS, thread_name_prefix="joint") as pool:
        return list(pool.map(work, range(joints)))
