"""Loops compiled by numba, kept in its cache where there is one."""

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar, cast

from numba import njit

Loop = TypeVar("Loop", bound=Callable[..., Any])
Record: TypeAlias = Any  # a group of numbers as compiled code sees it: the fields of a dataclass


ANY_ORDER = {"reassoc", "nsz", "contract"}
"""What a compiler may do to add up several numbers at a time; infinities and what is no number stay what they are."""
OPTIONS: dict[str, Any] = {"nogil": True, "no_cfunc_wrapper": True}
"""No loop is called through a pointer from C: the entry for that would take a fifth of the time of compiling."""


def compiled(signature: str | None = None, *, any_order: bool = False) -> Callable[[Loop], Loop]:
    """Compile a loop; it gives the interpreter away while it runs.

    With a signature, importing the module compiles it (or loads it from the cache) instead of the first call. In an
    installation that nobody may write to, without a home for the cache, it is compiled anew in every process. Sums in
    any order are several times as fast, and differ in their rounding.
    """
    freedom = ANY_ORDER if any_order else False

    def decorate(loop: Loop) -> Loop:
        try:
            return cast("Loop", njit(signature, cache=True, fastmath=freedom, **OPTIONS)(loop))
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            return cast("Loop", njit(signature, fastmath=freedom, **OPTIONS)(loop))

    return decorate
