"""The table of the only names, where the log separates them, from rows by hand."""

import pytest

from benchmarks.hidden_effects.separable import by_effect, judged

ROWS = (
    ("backlash", 0, "named", "backlash", "0.3"),
    ("backlash", 1, "ambiguous", "backlash|presliding", "1.0"),
    ("backlash", 2, "ambiguous", "backlash|presliding", "0.5"),
    ("backlash", 3, "named", "backlash", "0.2"),
    ("backlash", 4, "", "", "3.0"),
    ("cable_spring", 5, "ambiguous", "cable_spring|joint_limit_stop", "3.0"),
)
KNOWN = (("backlash", 0, "True", ""), ("backlash", 1, "True", ""), ("backlash", 2, "False", "presliding"))


@pytest.fixture
def rows() -> list[dict[str, str]]:
    names = ("truth", "seed", "verdict", "sets", "partial")
    return [dict(zip(names, map(str, row), strict=True), scenario="joint", scales="1.0") for row in ROWS]


@pytest.fixture
def known() -> dict[tuple[str, str], dict[str, str]]:
    return {
        (truth, str(seed)): {"truth": truth, "seed": str(seed), "separates": separates, "close": close}
        for truth, seed, separates, close in KNOWN
    }


def test_what_is_weak_or_has_no_answer_or_other_names_is_not_judged(rows: list[dict[str, str]]) -> None:
    assert [row["seed"] for row in judged(rows)] == ["0", "1", "2"]


def test_the_only_name_counts_where_the_log_separates(
    rows: list[dict[str, str]], known: dict[tuple[str, str], dict[str, str]]
) -> None:
    line, total = by_effect(judged(rows), known).splitlines()[2:]
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[:2] == ["backlash", "3"]
    assert [cell.split(" ")[0] for cell in cells[2:5]] == ["67", "50", "0"]
    assert cells[5] == "presliding 1"
    assert total.startswith("| all | 3 |")
