"""Loops compiled by numba, kept in its cache where there is one."""

import os
from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any, TypeAlias, TypeVar, cast

from numba import njit
from numba.core.caching import IndexDataCacheFile

Loop = TypeVar("Loop", bound=Callable[..., Any])
Record: TypeAlias = Any  # a group of numbers as compiled code sees it: the fields of a dataclass


ANY_ORDER = {"reassoc", "nsz", "contract"}
"""What a compiler may do to add up several numbers at a time; infinities and what is no number stay what they are."""
OPTIONS: dict[str, Any] = {"nogil": True, "no_cfunc_wrapper": True}
"""No loop is called through a pointer from C: the entry for that would take a fifth of the time of compiling."""


class _Index(IndexDataCacheFile):
    """What is cached of a loop; nothing, where an older version of the program has cached it."""

    def _load_index(self) -> dict[Any, str]:
        try:
            return cast("dict[Any, str]", super()._load_index())  # type: ignore[no-untyped-call]
        except (AttributeError, ImportError):  # it names classes that are gone, or elsewhere now
            return {}


def compiled(signature: str | None = None, *, any_order: bool = False, inline: bool = False) -> Callable[[Loop], Loop]:
    """Compile a loop; it gives the interpreter away while it runs.

    With a signature, importing the module compiles it (or loads it from the cache) instead of the first call. In an
    installation that is read-only, without a home for the cache, it is compiled anew in every process. Sums in
    any order are several times as fast, and differ in their rounding. What is inline becomes a part of the loops that
    call it and is not compiled by itself; for what is small or is called at one place.
    """
    options = OPTIONS | {"fastmath": ANY_ORDER if any_order else False, "inline": "always" if inline else "never"}

    def decorate(loop: Loop) -> Loop:
        try:
            made = njit(cache=True, **options)(loop)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            return cast("Loop", njit(signature, **options)(loop))
        index = made._cache._cache_file  # noqa: SLF001 - numba itself looks at the file of the loop alone
        index.__class__, index._version = _Index, f"{index._version} {_age(made)}"  # noqa: SLF001
        if signature is not None:
            made.compile(signature)
            made.disable_compile()
        return cast("Loop", made)

    return decorate


@cache
def _age(made: Any) -> int:  # noqa: ANN401 - a loop that numba has compiled
    """Return a number that changes with the file of a loop and with those of all loops that it calls."""
    code, known = made.py_func.__code__, made.py_func.__globals__
    used = [known[name] for name in code.co_names if name in known]
    used += [getattr(one, name, None) for one in used if isinstance(one, ModuleType) for name in code.co_names]
    file = os.stat(code.co_filename)  # noqa: PTH116 - a quarter of the time
    return hash((file.st_mtime_ns, file.st_size, *(_age(one) for one in used if isinstance(one, type(made)))))
