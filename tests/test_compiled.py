import subprocess
import sys

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
