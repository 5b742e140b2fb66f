import subprocess
import sys

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
