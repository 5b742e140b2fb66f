import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from friction_audit.joint_log import Float, read_only

WITHOUT_A_CACHE = """
from numba.core import caching
caching.CacheImpl._locator_classes = []
from friction_audit.compiled import compiled

@compiled()
def double(x):
    return 2 * x

print(double(21))
"""


def test_a_loop_compiles_where_no_cache_can_be_written() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT_A_CACHE], capture_output=True, text=True, check=True)
    assert done.stdout == "42\n"


@pytest.mark.parametrize("numbers", [np.arange(6.0), np.arange(12.0)[::2], np.asfortranarray(np.ones((3, 2)))])
def test_numbers_for_a_loop_are_of_one_kind(numbers: Float) -> None:
    given = read_only(numbers)
    assert given.flags.c_contiguous
    assert not given.flags.writeable
    assert numbers.flags.writeable
    np.testing.assert_array_equal(given, numbers)


INNER = """
from friction_audit.compiled import compiled

@compiled()
def inner(x):
    return {factor} * x
"""
OUTER = """
import inner
from friction_audit.compiled import compiled

@compiled()
def outer(x):
    return inner.inner(x) + 1

print(outer(20))
"""


def test_a_loop_is_compiled_again_where_a_loop_that_it_calls_has_changed(tmp_path: Path) -> None:
    (tmp_path / "outer.py").write_text(OUTER)
    for factor, printed in ((2, "41\n"), (30, "601\n")):
        (tmp_path / "inner.py").write_text(INNER.format(factor=factor))
        command = [sys.executable, str(tmp_path / "outer.py")]
        assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == printed


def test_a_cache_that_names_what_is_gone_is_none(tmp_path: Path) -> None:
    point = "from typing import NamedTuple\nclass {name}(NamedTuple):\n    x: float\n"
    for name in ("Point", "Place"):
        (tmp_path / "point.py").write_text(point.format(name=name))
        (tmp_path / "loop.py").write_text(
            "import point\nfrom friction_audit.compiled import compiled\n\n"
            "@compiled()\ndef f(p):\n    return p.x\n\nmade = [getattr(point, n) for n in dir(point) if n[0] == 'P']\n"
            "print(f(made[0](1.0)))\n"
        )
        os.utime(tmp_path / "loop.py", (0, 0))
        command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import loop"]
        assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "1.0\n"
