"""Judgements of answers, and the summary of figures, from rows by hand."""

from pathlib import Path

from benchmarks.answers import exact, first, held, held_or_negligible, misnamed, named, own_name, share, wrong
from benchmarks.diagnosis_summary import in_the_other, load, mistake, page, same
from benchmarks.resume import Job, Row, read


def answer(truth: str, sets: str, verdict: str = "named", **more: str) -> dict[str, str]:
    return {"truth": truth, "sets": sets, "verdict": verdict, "negligible": "", "partial": "0.5", "seed": "1"} | more


def test_an_alternative_is_in_the_answer_and_is_not_the_only_name() -> None:
    row = answer("stribeck", "presliding|stribeck;torque_bias", "ambiguous")
    assert held(row)
    assert wrong(row)
    assert not misnamed(row)
    assert not exact(row)
    assert not first(row)
    assert not own_name(row)
    assert own_name(answer("stribeck", "torque_bias;stribeck"))
    assert exact(answer("stribeck", "stribeck"))
    assert first(answer("stribeck", "stribeck;torque_bias"))


def test_a_negligible_effect_is_no_name() -> None:
    row = answer("stribeck", "", "adequate", negligible="stribeck")
    assert not named(row)
    assert not held(row)
    assert held_or_negligible(row)
    assert mistake("effects", row, set()) == "listed as negligible"
    assert mistake("effects", row | {"partial": "0.2"}, set()) == ""
    assert mistake("effects", row | {"partial": "0.2"}, {("stribeck", "1")}) == "listed as negligible"


def test_a_name_where_nothing_is_hidden_is_wrong() -> None:
    assert wrong(answer("none", "stribeck"))
    assert mistake("smoothed", answer("none", "stribeck"), set()) == "a name"
    assert mistake("effects", answer("stribeck", "stribeck", hidden_here="False"), set()) == "a name"
    assert mistake("outside", answer("hum", "stribeck"), set()) == "a name"
    assert mistake("outside", answer("hum", "stribeck", "unexplained"), set()) == ""


def test_names_of_one_half_on_the_other() -> None:
    one, other = answer("", "a;b|c", "ambiguous"), answer("", "d|a", "ambiguous")
    assert in_the_other(one, other) == [True, False]
    assert in_the_other(other, one) == [False]
    assert same(one, answer("", "c|b;a", "ambiguous"))
    assert not same(one, other)


def test_an_interval_is_that_of_wilson() -> None:
    assert share([False] * 200, 1) == "0.0 (0.0 to 1.9)"


def doubled(task: Row) -> list[dict[str, str]]:
    return [{**task, "twice": str(2 * int(task["seed"]))}]


def test_a_table_is_gone_on_with(tmp_path: Path) -> None:
    path, fields = tmp_path / "rows.csv", ("truth", "seed", "twice")
    for last in (2, 4):
        Job(fields, [{"truth": "none", "seed": str(seed)} for seed in range(last)], doubled).run(path, 1)
    assert sorted(row["twice"] for row in read(path)) == ["0", "2", "4", "6"]


def test_the_page_of_figures_stands_without_any_rows(tmp_path: Path) -> None:
    assert "one effect from 0.3" in page(load(tmp_path))
