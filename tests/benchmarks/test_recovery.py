"""Numbers beside the truth, from an answer by hand."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from benchmarks.hidden_effects.draw import Case, draw_case
from benchmarks.hidden_effects.recovery import compared


@pytest.fixture
def case() -> Case:
    return draw_case(0, ("stribeck",), 1.0)


def stribeck(form: int = 0) -> Any:
    return cast("Any", SimpleNamespace(excess_nm=0.2, speed_rad_s=0.1, form=form))


def test_truth_estimate_and_interval(case: Case) -> None:
    (row,) = compared("stribeck", stribeck(), case, {"stribeck_excess_nm": (0.15, 0.12, 0.18)})
    assert row["truth"] == 0.2
    assert row["estimate"] == 0.15
    assert row["half_width"] == pytest.approx(0.03)
    assert row["holds"] is False


def test_another_form_has_no_such_number(case: Case) -> None:
    assert compared("stribeck", stribeck(form=1), case, {"stribeck_excess_nm": (0.15, 0.12, 0.18)}) == []


def test_an_amplitude_has_no_interval() -> None:
    case = draw_case(0, ("gravity_error",), 1.0)
    found = {"gravity_cos_nm": (3.0, 2.0, 4.0), "gravity_sin_nm": (4.0, 3.0, 5.0)}
    (row,) = compared("gravity_error", cast("Any", SimpleNamespace(torque_nm=5.0)), case, found)
    assert (row["estimate"], row["half_width"], row["holds"]) == (5.0, None, None)
