"""Help and usage errors load no numerics."""

import subprocess
import sys
from pathlib import Path

from friction_audit.cli import NAMES, choices
from friction_audit.cli.compare import ARMS, METHOD_NAMES
from friction_audit.cli.reproduce import PAPER_FIGURES
from friction_audit.compensation.comparison import METHODS, SCENES
from friction_audit.compensation.settings import COMPETITORS, COUNTERFACTUALS
from friction_audit.reporting.html.log_page import REPORT_FORMATS
from friction_audit.reproduce import REPRODUCTIONS

HEAVY: tuple[str, ...] = ("numpy", "scipy", "pandas", "pyarrow", "numba", "matplotlib")
HEAVY += ("rich", "rosbags", "mcap", "mujoco", "statsmodels")

SCRIPT = """
import sys
from friction_audit.cli import main
for words in sys.argv[1:]:
    try:
        main(words.split())
    except SystemExit:
        pass
print(*sys.modules, file=sys.stderr)
"""


def loaded(*commands: str) -> tuple[str, set[str]]:
    """Return what commands say, one after another in a process, and the modules that they loaded."""
    done = subprocess.run([sys.executable, "-c", SCRIPT, *commands], capture_output=True, text=True, check=True)
    return done.stdout + done.stderr, set(done.stderr.splitlines()[-1].split())


def test_nothing_heavy_is_loaded() -> None:
    said, modules = loaded("--help", *(f"{name} --help" for name in NAMES), "estimate")
    assert said.count("Usage") == len(NAMES) + 2
    assert modules.isdisjoint(HEAVY)


def test_names_of_options_are_those_of_the_steps() -> None:
    assert set(choices.COMPENSATORS) == {"energy", *COMPETITORS}
    assert tuple(COUNTERFACTUALS) == choices.ASSUMPTIONS
    assert tuple(method.name for method in METHODS) == METHOD_NAMES
    assert tuple(scene.name for scene in SCENES) == ARMS
    assert tuple(one.figure for one in REPRODUCTIONS) == PAPER_FIGURES
    assert {name: ending for name, (ending, _) in REPORT_FORMATS.items()} == choices.REPORT_FORMATS


MOST_LOADED = 90
"""Of the modules of the package."""


def test_an_estimate_with_figures_loads_no_other_analysis(tmp_path: Path) -> None:
    log = Path(__file__).parents[2] / "sample_logs" / "bench_rig.csv"
    _, modules = loaded(f"estimate {log} -q -o {tmp_path}/out")
    own = {name for name in modules if name.startswith("friction_audit.")}
    assert (tmp_path / "out" / "coefficients.png").exists()
    assert "friction_audit.reporting.figures.estimate" in own
    others = ("diagnosis", "compensation", "simulation", "drift", "dynamics", "batch", "reproduce")
    assert [name for name in own if name.split(".")[1] in others] == []
    assert len(own) <= MOST_LOADED
