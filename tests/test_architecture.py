"""The rules that hold for the whole tree: import contracts, style, types, and what the README promises."""

import ast
import os
import subprocess
import sys
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


def test_mypy_is_clean(request: pytest.FixtureRequest) -> None:
    # To write a cache takes a fifth of the time, which is lost in a copy that is tested once. There, tests and
    # benchmarks, two fifths of the time, are left to the thorough run.
    known = (ROOT / ".mypy_cache").exists()
    what = () if known or request.config.getoption("thorough") else ("src",)
    result = run("mypy", *(() if known else ("--cache-dir", os.devnull)), *what)
    assert result.returncode == 0, result.stdout + result.stderr


def test_the_readme_gives_the_two_commands_and_ci_runs_the_second() -> None:
    readme = (ROOT / "README.md").read_text()
    assert "<!-- main job -->" in readme
    assert "friction-audit estimate sample_logs/" in readme.split("<!-- main job -->")[1].split("```")[1]
    assert "pytest" in readme.split("<!-- tests -->")[1].split("```")[1]
    assert "README.md" in (ROOT / ".ci" / "run").read_text()


def test_the_version_has_a_changelog_section() -> None:
    assert f"## [{__version__}]" in (ROOT / "CHANGELOG.md").read_text()


# Of src/ and tests/. A number goes up only with its reason in the same commit; it goes down with what is saved.
SIZE = {
    "lines": 42_514,  # templates, definitions and SQL are files of their own, sentences a table
    "files": 226,
    "code lines of the longest function": 59,  # dynamics/transmission.py: one compiled loop, split it is 13 % slower
    "per cent of functions of at most 3 code lines": 21,
    "lines of tests": 23_537,
}


def code_lines(text: str) -> set[int]:
    """Return the lines that hold code: no blanks and comments."""
    return {number for number, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"}


def function_lengths(path: Path) -> list[int]:
    """Return the code lines of each function of a module, its docstring not counted."""
    text = path.read_text()
    held, lengths = code_lines(text), []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0]
            documented = ast.get_docstring(node) is not None
            words = set(range(first.lineno, (first.end_lineno or 0) + 1)) if documented else set()
            lengths.append(len(held.intersection(range(node.lineno, (node.end_lineno or 0) + 1)) - words))
    return lengths


def test_the_house_does_not_grow() -> None:
    source, tests = (sorted((ROOT / folder).rglob("*.py")) for folder in ("src", "tests"))
    lengths = [length for path in source for length in function_lengths(path)]
    found = {
        "lines": sum(len(path.read_text().splitlines()) for path in source),
        "files": len(source),
        "code lines of the longest function": max(lengths),
        "per cent of functions of at most 3 code lines": 100 * sum(length <= 3 for length in lengths) // len(lengths),
        "lines of tests": sum(len(path.read_text().splitlines()) for path in tests),
    }
    grown = {name: (size, SIZE[name]) for name, size in found.items() if size > SIZE[name]}
    assert not grown, grown
