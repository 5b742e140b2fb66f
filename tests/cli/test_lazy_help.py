"""Help and usage errors load no numerics."""

import subprocess
import sys
from pathlib import Path

import pytest

from friction_audit.cli import choices
from friction_audit.cli.compare import ARMS, METHOD_NAMES
from friction_audit.cli.reproduce import PAPER_FIGURES
from friction_audit.compensation.comparison import METHODS, SCENES
from friction_audit.compensation.settings import COMPETITORS, COUNTERFACTUALS
from friction_audit.reproduce import REPRODUCTIONS

HEAVY = (
    *("numpy", "scipy", "pandas", "pyarrow", "numba", "matplotlib"),
    *("rich", "rosbags", "mcap", "mujoco", "statsmodels"),
)

SCRIPT = """
import sys
from friction_audit.cli import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
print(*sys.modules, file=sys.stderr)
"""


def loaded(*words: str) -> tuple[str, set[str]]:
    """Return what a command says, and the modules that it loaded."""
    done = subprocess.run([sys.executable, "-c", SCRIPT, *words], capture_output=True, text=True, check=True)
    return done.stdout + done.stderr, set(done.stderr.splitlines()[-1].split())


@pytest.mark.parametrize(
    "words",
    ["--help", "estimate --help", "plot --help", "info --help", "convert --help", "simulate --help", "estimate"],
)
def test_nothing_heavy_is_loaded(words: str) -> None:
    said, modules = loaded(*words.split())
    assert "Usage" in said
    assert modules.isdisjoint(HEAVY)


def test_names_of_options_are_those_of_the_steps() -> None:
    assert set(choices.COMPENSATORS) == {"energy", *COMPETITORS}
    assert tuple(COUNTERFACTUALS) == choices.ASSUMPTIONS
    assert tuple(method.name for method in METHODS) == METHOD_NAMES
    assert tuple(scene.name for scene in SCENES) == ARMS
    assert tuple(one.figure for one in REPRODUCTIONS) == PAPER_FIGURES


MOST_LOADED = 90
"""Of the modules of the package."""


def test_an_estimate_with_figures_loads_no_other_analysis(tmp_path: Path) -> None:
    log = Path(__file__).parents[2] / "sample_logs" / "bench_rig.csv"
    _, modules = loaded("estimate", str(log), "-q", "-o", str(tmp_path / "out"))
    own = {name for name in modules if name.startswith("friction_audit.")}
    assert (tmp_path / "out" / "coefficients.png").exists()
    assert "friction_audit.reporting.figures.estimate" in own
    others = ("diagnosis", "compensation", "simulation", "drift", "dynamics", "batch", "reproduce")
    assert [name for name in own if name.split(".")[1] in others] == []
    assert len(own) <= MOST_LOADED
