import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.stribeck import EXPONENTIAL, LORENTZIAN, PIECEWISE, Stribeck, excess_nm
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(Stribeck.forms))
speeds = st.floats(0.0, 5.0)


def excess(speed: float, **numbers: float) -> float:
    return excess_nm(pack([Stribeck(**numbers)])[0], speed)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("form", "share"), [(EXPONENTIAL, math.exp(-1.0)), (LORENTZIAN, 0.5), (PIECEWISE, 0.0)], ids=Stribeck.forms
)
def test_at_the_stribeck_speed_each_form_has_its_own_share_left(form: int, share: float) -> None:
    assert excess(0.1, excess_nm=0.3, speed_rad_s=0.1, form=form) == pytest.approx(0.3 * share)


def test_exponent_of_one_is_that_of_bo_and_pavelescu() -> None:
    assert excess(0.2, excess_nm=0.3, speed_rad_s=0.1, exponent=1.0) == pytest.approx(0.3 * math.exp(-2.0))


@pytest.mark.parametrize("form", FORMS)
def test_all_of_it_is_there_at_rest(form: int) -> None:
    assert excess(0.0, excess_nm=0.3, form=form) == 0.3


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(slow=speeds, fast=speeds)
def test_it_falls_with_speed_and_never_drives(form: int, slow: float, fast: float) -> None:
    slow, fast = sorted((slow, fast))
    assert excess(slow, excess_nm=0.3, form=form) >= excess(fast, excess_nm=0.3, form=form) >= 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("speed", [0.0, 0.03, 2.0])
def test_nothing_hidden_is_exactly_zero(form: int, speed: float) -> None:
    assert excess(speed, form=form) == 0.0
