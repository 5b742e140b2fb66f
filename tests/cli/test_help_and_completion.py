"""Help and usage errors load no numerics; what bash asks for is answered."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

from friction_audit.cli import NAMES, command_of, parameters
from friction_audit.cli.compare import ARMS, FIGURES, METHOD_NAMES
from friction_audit.cli.reproduce import PAPER_FIGURES
from friction_audit.compensation.comparison.methods import METHODS, SETUPS
from friction_audit.io.writers.write_log import WRITERS as LOG_WRITERS
from friction_audit.reporting import ENDINGS
from friction_audit.reporting.figures import comparison
from friction_audit.reporting.html.log_page import WRITERS
from friction_audit.reproduce import REPRODUCTIONS
from friction_audit.simulation.scenarios import SCENARIOS

PROGRAM = Path(sys.executable).parent / "friction-audit"
ASK = """
source ~/.bashrc
COMP_WORDS=({})
COMP_CWORD={}
_friction_audit_completion friction-audit
echo "${{COMPREPLY[@]}}"
"""


def asked(home: Path, words: str) -> list[str]:
    """Return what completion offers for the last of the words."""
    env = os.environ | {"HOME": str(home), "PATH": f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}"}
    script = ASK.format(words, len(words.split()) - 1)
    done = subprocess.run(["bash", "--norc", "-c", script], env=env, capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.skipif(not shutil.which("bash") or not PROGRAM.exists(), reason="no bash, or the program is not installed")
def test_completion_is_installed_for_bash_and_answers(tmp_path: Path) -> None:
    env = os.environ | {"HOME": str(tmp_path)}
    # The program looks for the shell among the processes above it; the `;` keeps bash there.
    install = ["bash", "-c", '"$0" --install-completion; exit $?', str(PROGRAM)]
    done = subprocess.run(install, env=env, capture_output=True, text=True, check=True)
    assert "bash completion installed" in done.stdout
    assert asked(tmp_path, "friction-audit est") == ["estimate"]
    assert asked(tmp_path, "friction-audit batch-report --fa") == ["--fail-on"]
    assert asked(tmp_path, "friction-audit estimate run.csv --drive ha") == ["hand"]
    assert asked(tmp_path, "friction-audit plot run.csv --figures energy,co") == ["energy,coefficients"]


def offered(command: str, option: str, begun: str = "") -> list[str]:
    chosen = command_of(command)
    (param,) = (p for p in chosen.params if option in (*p.opts, p.name))
    return [item.value for item in param.shell_complete(typer.Context(chosen), begun)]


def listed() -> Iterator[tuple[str, str, list[str]]]:
    """Yield each option whose help lists its names: command, option, names."""
    for name in NAMES:
        for param in command_of(name).params:
            names = (param.metavar or "").removesuffix(",...").split("|")
            if len(names) > 1 and not any(re.search("[A-Z]{2}", name) for name in names):
                yield name, max(param.opts, key=len), names


def test_every_name_that_the_help_lists_is_offered() -> None:
    assert {"--drive", "--gravity", "--robot", "--compensator", "--arm", "--figures"} <= {one for _, one, _ in listed()}
    for command, option, names in listed():
        assert offered(command, option) == names, (command, option)
        assert offered(command, option, names[-1]) == [n for n in names if n.startswith(names[-1])], (command, option)


@pytest.mark.parametrize(("command", "option", "names"), [
    ("simulate", "scenario", [one.name for one in SCENARIOS]),
    ("simulate", "--effect", parameters.EFFECTS),
    ("compare", "--effect", parameters.EFFECTS),
    ("diagnose", "--candidates", parameters.EFFECTS),
    ("simulate", "--dialect", [one.name for one in LOG_WRITERS]),
    ("convert", "--dialect", [one.name for one in LOG_WRITERS]),
])  # fmt: skip
def test_names_that_another_option_lists_are_offered(command: str, option: str, names: tuple[str, ...]) -> None:
    assert offered(command, option) == list(names)
    assert offered(command, option, names[0][:2])[0] == names[0]
    assert offered(command, option, "?") == []


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
    assert tuple(method.name for method in METHODS) == METHOD_NAMES
    assert tuple(setup.name for setup in SETUPS) == ARMS
    assert tuple(comparison.FIGURES) == FIGURES
    assert tuple(one.figure for one in REPRODUCTIONS) == PAPER_FIGURES
    assert WRITERS.keys() == ENDINGS.keys()


MOST_LOADED = 90  # of the modules of the package


def test_an_estimate_with_figures_loads_no_other_analysis(logs: Path, tmp_path: Path) -> None:
    _, modules = loaded(f"estimate {logs}/moved1.csv -q -o {tmp_path}/out --figures coefficients")
    own = {name for name in modules if name.startswith("friction_audit.")}
    assert (tmp_path / "out" / "coefficients.png").exists()
    assert "friction_audit.reporting.figures.estimate" in own
    others = ("diagnosis", "compensation", "simulation", "drift", "dynamics", "batch", "reproduce")
    assert [name for name in own if name.split(".")[1] in others] == []
    assert len(own) <= MOST_LOADED
