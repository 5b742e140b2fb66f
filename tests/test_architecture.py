"""The rules that hold for the whole tree: import contracts, style, types, and what the README promises."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from friction_audit import __version__

ROOT = Path(__file__).parents[1]


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)


def test_import_contracts_hold() -> None:
    tool = Path(sys.executable).parent / "lint-imports"
    result = subprocess.run([tool, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.parametrize("arguments", [("check",), ("format", "--check")])
def test_ruff_is_clean(arguments: tuple[str, ...]) -> None:
    result = run("ruff", *arguments, "--no-cache", ".")
    assert result.returncode == 0, result.stdout + result.stderr


def test_mypy_is_clean() -> None:
    result = run("mypy")
    assert result.returncode == 0, result.stdout + result.stderr


def test_no_module_is_a_drawer_for_odds_and_ends() -> None:
    drawers = {"utils", "util", "helpers", "common", "tools", "misc"}
    assert [p for p in (ROOT / "src").rglob("*.py") if p.stem in drawers] == []


def test_the_readme_gives_the_two_commands_and_ci_runs_the_second() -> None:
    readme = (ROOT / "README.md").read_text()
    assert "<!-- main job -->" in readme
    assert "friction-audit estimate sample_logs/" in readme.split("<!-- main job -->")[1].split("```")[1]
    assert "pytest" in readme.split("<!-- tests -->")[1].split("```")[1]
    assert "README.md" in (ROOT / ".ci" / "run").read_text()


def test_the_version_has_a_changelog_section() -> None:
    assert f"## [{__version__}]" in (ROOT / "CHANGELOG.md").read_text()


def test_the_package_declares_what_it_imports() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["requires-python"] == ">=3.11"
    assert "Apache-2.0" in project["license"]
