"""Loops compiled by numba, kept in its cache where there is one."""

import os
from collections.abc import Callable
from functools import cache, cached_property, partial, update_wrapper
from importlib import import_module
from types import ModuleType
from typing import Any, TypeAlias, TypeVar, cast

Loop = TypeVar("Loop", bound=Callable[..., Any])
Record: TypeAlias = Any  # a group of numbers as compiled code sees it: the fields of a dataclass

ANY_ORDER = {"reassoc", "nsz", "contract"}
"""What a compiler may do to add up several numbers at a time; infinities and what is no number stay what they are."""
OPTIONS: dict[str, Any] = {"nogil": True, "no_cfunc_wrapper": True}
"""No loop is called through a pointer from C: the entry for that would take a fifth of the time of compiling."""


def compiled(signature: str | None = None, *, any_order: bool = False, inline: bool = False) -> Callable[[Loop], Loop]:
    """Compile a loop; it gives the interpreter away while it runs.

    With a signature, for these types alone. In an installation that is read-only, without a home for the cache, it is
    compiled anew in every process. Sums in any order are several times as fast, and differ in their rounding. What is
    inline becomes a part of the loops that call it and is not compiled by itself; for what is small or is called at one
    place.
    """
    options = OPTIONS | {"fastmath": ANY_ORDER if any_order else False, "inline": "always" if inline else "never"}
    return cast("Callable[[Loop], Loop]", partial(_Compiled, signature, options))


class _Compiled:
    """A loop that numba compiles when it is used: to import numba takes 70 MB and a third of a second.

    A compiled loop that calls it finds here what it looks for in a function that numba has compiled.
    """

    def __init__(self, signature: str | None, options: dict[str, Any], loop: Callable[..., Any]) -> None:
        update_wrapper(self, loop)
        self.py_func, self.signature, self._options = loop, signature, options

    def __call__(self, *given: Any) -> Any:  # noqa: ANN401 - what the loop takes, and returns
        return self.dispatcher(*given)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - of numba's own
        return getattr(self.dispatcher, name)

    @cached_property
    def dispatcher(self) -> Any:  # noqa: ANN401 - of numba, which has no types
        """What numba makes of the loop; two threads at once may make two, and both are right."""
        from numba import njit

        try:
            made = njit(cache=True, **self._options)(self.py_func)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            return njit(self.signature, **self._options)(self.py_func)
        index = made._cache._cache_file  # noqa: SLF001 - numba itself looks at the file of the loop alone
        index._load_index, index._version = partial(_known, index._load_index), f"{index._version} {_age(self)}"  # noqa: SLF001
        if self.signature is not None:
            made.compile(self.signature)
            made.disable_compile()
        return made


def load(module: str) -> list[Any]:
    """Import a module and make its loops for types that are given: the first loop of a process takes 0.4 s to load."""
    loops = (one for one in vars(import_module(module)).values() if isinstance(one, _Compiled))
    return [one.dispatcher for one in loops if one.signature is not None]


def _known(read: Callable[[], dict[Any, str]]) -> dict[Any, str]:
    """Return what is cached of a loop; nothing, where an older version of the program has cached it."""
    try:
        return read()
    except (AttributeError, ImportError):  # it names classes that are gone, or elsewhere now
        return {}


@cache
def _age(made: _Compiled) -> int:
    """Return a number that changes with the file of a loop and with those of all loops that it calls."""
    code, known = made.py_func.__code__, made.py_func.__globals__
    used = [known[name] for name in code.co_names if name in known]
    used += [getattr(one, name, None) for one in used if isinstance(one, ModuleType) for name in code.co_names]
    file = os.stat(code.co_filename)  # noqa: PTH116 - a quarter of the time
    return hash((file.st_mtime_ns, file.st_size, *(_age(one) for one in used if isinstance(one, _Compiled))))
