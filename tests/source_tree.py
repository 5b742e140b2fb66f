"""The program's own source as trees, parsed once for all tests that read it."""

import ast
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"


@cache
def nodes() -> tuple[tuple[str, ast.AST], ...]:
    """Return all nodes of the program with the file they are in."""
    files = sorted(SOURCE.rglob("*.py"))
    return tuple((path.name, node) for path in files for node in ast.walk(ast.parse(path.read_text())))
