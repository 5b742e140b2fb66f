"""One specification of columns: document, schema, file and tables for people are made of it."""

import math
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest

from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.figures.panels import label_in_unit
from friction_audit.reporting.table import INTERVAL, Column, Record

INNER = Record(Column("share"), Column("word", ("a", "b")))
HISTORY = Record(Column("cycle", int), Column("energy", unit="J"), name="history", over="cycle")
SPEC = Record(
    Column("coulomb", Coefficient, "friction", "found.coulomb", unit="N m", title="Coulomb", on="jftp"),
    Column("reason", str, "why not", null=True),
    Column("inner", INNER, on="j", null=True),
    Column("pairs", {"*": INTERVAL}, on="j"),
    Column("history", HISTORY, on="j"),
    Column("phrase", str, get="found.phrase", title="phrase", words=True, on="tp"),
    name="spec",
    summary="a row",
)


def row(**changed: object) -> SimpleNamespace:
    found = SimpleNamespace(coulomb=Coefficient(value=0.3, low=0.2, high=0.4), phrase="words to be broken")
    cells = {
        "found": found,
        "reason": "at 0.2 N m",
        "inner": {"share": math.inf, "word": "a"},
        "pairs": {"x": (1.0, math.nan)},
        "history": SimpleNamespace(cycle=np.array([1, 2]), energy_j=np.array([0.5, math.nan])),
    }
    return SimpleNamespace(**cells | changed)


NOTHING = {"found": SimpleNamespace(coulomb=UNDETERMINED), "inner": None, "history": None, "reason": ""}


@pytest.mark.parametrize("changed", [{}, NOTHING])
def test_a_document_keeps_to_its_schema(changed: dict[str, object]) -> None:
    jsonschema.Draft202012Validator(SPEC.schema()).validate(SPEC.json(row(**changed)))


def test_a_document_has_units_in_its_keys_and_null_for_no_number() -> None:
    assert SPEC.json(row(), "A") == {
        "coulomb_nm": {"value": 0.3, "ci95": [0.2, 0.4]},
        "reason": "at 0.2 A",
        "inner": {"share": None, "word": "a"},
        "pairs": {"x": [1.0, None]},
        "history": [{"cycle": 1, "energy_j": 0.5}, {"cycle": 2, "energy_j": None}],
    }


@pytest.mark.parametrize(("unit", "ends"), [("N m", ("nm", "j")), ("A", ("a", "a_rad")), ("mA", ("ma", "ma_rad"))])
def test_files_have_the_unit_of_the_torque_in_their_columns(unit: str, ends: tuple[str, str]) -> None:
    one, two = SimpleNamespace(joint=1, name="one", found=row()), SimpleNamespace(joint=2, name="two", found=None)
    table = SPEC.file([one], lambda one: [one.found, one.found], unit)
    assert list(table.types) == [*(f"coulomb{end}_{ends[0]}" for end in ("", "_low", "_high")), "reason"]
    assert list(table.rows[0].columns[f"coulomb_low_{ends[0]}"]) == [0.2, 0.2]
    history = HISTORY.file([one, two], "found.history", unit)
    assert list(history.types) == ["cycle", f"energy_{ends[1]}"]
    assert [(rows.joint, len(rows)) for rows in history.rows] == [(1, 2)]


def test_a_narrow_terminal_cuts_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "22")
    lines = SPEC.people([row()], "t", unit="A").lines()
    assert lines[1].startswith("[A]") or "[A]" in lines[1]
    assert "0.30 ± 0.10" in lines[3]
    assert len(lines) > 4  # words go on in the next line
    assert all(line == line.rstrip() for line in lines)


def test_a_page_sorts_numbers_by_their_value() -> None:
    coulomb, phrase = SPEC.on("p")
    assert (coulomb.head("A"), coulomb.number, coulomb.sort_key(row())) == ("Coulomb [A]", True, 0.3)
    assert (phrase.number, phrase.sort_key(row())) == (False, None)
    assert coulomb.text(row(found=SimpleNamespace(coulomb=UNDETERMINED))) == "-"
    table = SPEC.people([row(found=SimpleNamespace(coulomb=UNDETERMINED, phrase="a"))])
    assert table.filled().columns == [phrase]


def test_axes_of_figures_have_the_unit_of_the_torque() -> None:
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure()
    figure.add_subplot().set_ylabel("Coulomb [N m]")
    assert label_in_unit(figure, "A").axes[0].get_ylabel() == "Coulomb [A]"
