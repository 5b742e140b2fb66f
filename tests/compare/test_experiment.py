"""The whole comparison, short."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.compare import METHODS, compare
from friction_audit.compare.draw import FIGURES, draw
from friction_audit.compare.told import MEASURES, tell_rows
from friction_audit.errors import AnalysisError
from tests.compare.conftest import CHOSEN, SEEDS, compared, short_joint


def test_every_method_has_its_rows_in_order() -> None:
    rows = compared().rows
    assert list(dict.fromkeys(row.method for row in rows)) == list(CHOSEN)
    for name in CHOSEN:
        roles = [row.role for row in rows if row.method == name]
        assert roles[0] == "paper"
        assert roles.count("best") == (0 if name in ("none", "oracle") else 1)
    assert all(len(row.outcomes) == SEEDS for row in rows)


def test_nobody_is_reported_who_was_tuned_for() -> None:
    assert not set(compared().seeds) & set(compared().tuning_seeds)


def test_by_hand_is_half_of_the_boldest_that_holds() -> None:
    (curve,) = (one for one in compared().curves if one.method == "torque_regulation")
    assert curve.limited
    assert curve.boldest_stable is not None
    row = compared().row("torque_regulation", "paper")
    assert row is not None
    assert f"{1 / (1 + curve.boldest_stable / 2):.2g}" in row.tuning.name
    assert row.margin > 1.4


def test_the_best_is_the_flattest_that_holds() -> None:
    for curve in compared().curves:
        held = [point for point in curve.points if point.stable]
        best = min(held, key=lambda point: abs(point.energy_slope_w.value))
        row = compared().row(curve.method, "best")
        assert row is not None
        assert row.tuning.name == best.tuning.name


def test_what_was_found() -> None:
    slopes = {
        row.method: row.interval(lambda outcome: outcome.energy_slope_w).value
        for row in compared().rows
        if row.role == "paper"
    }
    assert slopes["none"] > 0.1
    assert slopes["none"] > slopes["torque_regulation"] > abs(slopes["oracle"])
    assert abs(slopes["disturbance_observer"]) < 0.1 * slopes["none"]
    assert abs(slopes["energy"]) < 0.2 * slopes["none"]


def test_same_seeds_same_numbers() -> None:
    some = [method for method in METHODS if method.name in ("none", "oracle")]
    again = compare(short_joint(), SEEDS, some)
    for row in again.rows:
        before = compared().row(row.method, "paper")
        assert before is not None
        assert row.outcomes == before.outcomes


def test_figures_have_their_names() -> None:
    figures = draw(compared())
    assert tuple(figures) == FIGURES
    assert all(axes.has_data() for figure in figures.values() for axes in figure.axes if axes.get_visible())


def test_what_is_told_is_what_was_measured() -> None:
    for told, row in zip(tell_rows(compared()), compared().rows, strict=True):
        assert set(MEASURES) < set(told)
        slopes = [outcome.energy_slope_w for outcome in row.outcomes if outcome.stable]
        assert told["energy_slope_w"]["value"] == pytest.approx(np.mean(slopes))  # type: ignore[index]


def test_progress_rises_to_one() -> None:
    told: list[float] = []
    compare(short_joint(), SEEDS, METHODS[:1], told.append)
    assert told == sorted(told)
    assert told[-1] <= 1.0


def test_a_method_without_stable_tuning_is_named() -> None:
    (method,) = (one for one in METHODS if one.name == "torque_regulation")
    hopeless = replace(method, sweeps=(replace(method.sweeps[0], values=(40.0, 80.0)),))
    with pytest.raises(AnalysisError, match="torque regulation: no stable tuning"):
        compare(short_joint(), SEEDS, [METHODS[0], hopeless])
