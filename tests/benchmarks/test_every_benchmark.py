"""Every benchmark can be started: what it is made of at the top of its file is still what the program takes."""

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("bench_*.py")), ids=lambda path: path.stem)
def test_it_can_be_started(path: Path) -> None:
    assert runpy.run_path(str(path))["__doc__"]
