"""Tables as text: no number is ever cut."""

import pytest
from friction_audit.reporting.terminal.plain import plain_lines
from rich.table import Table


def table_of(number: str) -> Table:
    table = Table(box=None)
    for column in range(4):
        table.add_column(f"{column}", no_wrap=True)
    table.add_column("words")
    table.add_row(*[number] * 4, "some words that may be broken")
    return table


def test_a_narrow_terminal_cuts_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    number = "+0.1234 ± 0.0056"
    lines = plain_lines(table_of(number))
    assert lines[1].count(number) == 4
    assert len(lines) > 2  # words go on in the next line


def test_a_table_with_room_keeps_to_its_own_width(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    lines = plain_lines(table_of("1"))
    assert len(lines) == 2
    assert max(map(len, lines)) < 60
