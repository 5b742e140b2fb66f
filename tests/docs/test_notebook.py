"""The notebook of the documentation: every cell runs, and it is committed without results."""

import ast
import json
import re
from typing import Any

import matplotlib as mpl
import pytest

from tests.test_docs import DOCS

NOTEBOOK = DOCS / "notebook.ipynb"
MOST_BYTES = 20_000


def run(source: str, names: dict[str, Any]) -> Any:
    """Run a cell as a notebook does, and return the value of its last line."""
    module = ast.parse(source)
    last = module.body.pop() if isinstance(module.body[-1], ast.Expr) else None
    exec(compile(module, "cell", "exec"), names)
    if last is None:
        return None
    assert isinstance(last, ast.Expr)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)


def test_it_is_a_notebook_without_results() -> None:
    notebook = json.loads(NOTEBOOK.read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in notebook["cells"]}) == len(notebook["cells"])
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in notebook["cells"])
    assert NOTEBOOK.stat().st_size < MOST_BYTES


def test_every_cell_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(DOCS)
    mpl.use("agg")
    names: dict[str, Any] = {"__name__": "__main__"}
    cells = [cell for cell in json.loads(NOTEBOOK.read_text())["cells"] if cell["cell_type"] == "code"]
    shown = [run("".join(cell["source"]), names) for cell in cells]
    pages = [value._repr_html_() for value in shown if hasattr(value, "_repr_html_")]
    tables = [page for page in pages if page is not None]  # a figure has none: its picture is shown
    assert len(tables) == 3
    assert all("<table" in table for table in tables)
    assert names["diagnosis"].joints[0].effects[0].name == "stribeck"
    found = re.search(r"Coulomb friction: \+(\d+\.\d) %", capsys.readouterr().out)
    assert found is not None
    assert float(found[1]) == pytest.approx(10.0, abs=3.0)
