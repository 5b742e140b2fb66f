import subprocess
import sys

import pytest

from friction_audit import simulate


@pytest.mark.parametrize("name", simulate.__all__)
def test_public_name_is_there(name: str) -> None:
    assert getattr(simulate, name) is not None


def test_unknown_name_is_refused() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'bench_of_wood'"):
        simulate.bench_of_wood  # noqa: B018 - the access is the test


def test_package_does_not_bring_the_compiler_along() -> None:
    code = "import sys, friction_audit.simulate; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout.split() == [b"False"]
