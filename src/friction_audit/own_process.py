"""Whether this process is a command of friction-audit and nothing else, so that it is known what its threads do.

A program that uses this package as a library may have threads that hold anything.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_OWN = ContextVar("_OWN", default=False)


@contextmanager
def own_process() -> Iterator[None]:
    """Say in a block that this process belongs to friction-audit."""
    token = _OWN.set(True)
    try:
        yield
    finally:
        _OWN.reset(token)


def is_own_process() -> bool:
    """Return True in a block of ``own_process``."""
    return _OWN.get()
