"""The table of claims."""

import pytest
from friction_audit.reporting.terminal.compare import claim_table
from rich.text import Text

ROW = {"figure": "7b", "claim": "it holds", "paper": "yes", "ours": "1 N m", "value": 1.0, "holds": True, "note": "why"}


def lines_of(rows: list[dict[str, object]]) -> list[str]:
    parts = claim_table(rows)
    assert all(isinstance(part, Text) for part in parts)
    return [str(part) for part in parts]


def test_a_row_per_claim_and_the_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    lines = lines_of([ROW, ROW | {"holds": False}])
    assert lines[0].split() == ["fig", "claim", "paper", "ours", "holds"]
    assert [line.split()[-1] for line in lines[2:4]] == ["yes", "NO"]
    assert lines[-2:] == ["7b: why", "1 of 2 claims hold"]


def test_no_line_ends_with_a_space_and_none_is_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    lines = lines_of([ROW | {"claim": "words and " * 20}])
    assert all(line == line.rstrip() for line in lines)
    assert max(map(len, lines)) <= 60
