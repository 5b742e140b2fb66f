import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.stiction import IMMEDIATE, LOGARITHMIC, SATURATING, Stiction, excess_nm
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(Stiction.forms))
rests = st.floats(0.0, 1000.0)


def excess(rest_s: float, **numbers: float) -> float:
    return excess_nm(pack([Stiction(**numbers)])[0], rest_s)  # type: ignore[arg-type]


def test_saturating_has_63_percent_after_the_dwell_time_and_all_of_it_in_the_end() -> None:
    assert excess(0.5, excess_nm=0.2, dwell_s=0.5) == pytest.approx(0.2 * (1.0 - math.exp(-1.0)))
    assert excess(100.0, excess_nm=0.2, dwell_s=0.5) == pytest.approx(0.2)


def test_logarithmic_has_its_size_after_ten_seconds_and_grows_by_the_same_every_decade() -> None:
    at = [excess(rest, excess_nm=0.2, dwell_s=0.001, form=LOGARITHMIC) for rest in (1.0, 10.0, 100.0, 1000.0)]
    assert at[1] == pytest.approx(0.2)
    assert at[2] - at[1] == pytest.approx(0.2 * math.log(10.0) / math.log(10_001.0), rel=1e-3)
    assert at[3] - at[2] == pytest.approx(at[2] - at[1], rel=1e-3)


def test_immediate_does_not_wait() -> None:
    assert excess(0.0, excess_nm=0.2, form=IMMEDIATE) == excess(10.0, excess_nm=0.2, form=IMMEDIATE) == 0.2


@pytest.mark.parametrize("form", [SATURATING, LOGARITHMIC])
def test_no_rest_leaves_sliding_friction(form: int) -> None:
    assert excess(0.0, excess_nm=0.2, form=form) == 0.0


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(short=rests, long=rests)
def test_it_never_shrinks_with_the_rest(form: int, short: float, long: float) -> None:
    short, long = sorted((short, long))
    assert excess(long, excess_nm=0.2, form=form) >= excess(short, excess_nm=0.2, form=form) >= 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("rest_s", [0.0, 0.3, 60.0])
def test_nothing_hidden_is_exactly_zero(form: int, rest_s: float) -> None:
    assert excess(rest_s, form=form) == 0.0
