import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.friction_step import (
    ABRUPT,
    RAMP,
    SETTLING,
    FrictionStep,
    coulomb_factor,
    viscous_factor,
)
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(FrictionStep.forms))
DURATION_S = 60.0


def coulomb(t: float, **numbers: float) -> float:
    return coulomb_factor(pack([FrictionStep(**numbers)])[0], t, DURATION_S)  # type: ignore[arg-type]


def viscous(t: float, **numbers: float) -> float:
    return viscous_factor(pack([FrictionStep(**numbers)])[0], t, DURATION_S)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("form", "share"), [(ABRUPT, 1.0), (RAMP, 0.4), (SETTLING, 1.0 - math.exp(-0.4))], ids=FrictionStep.forms
)
def test_two_seconds_after_a_step_of_five(form: int, share: float) -> None:
    assert coulomb(22.0, change=0.5, at_share=1.0 / 3.0, form=form) == pytest.approx(1.0 + 0.5 * share)


@pytest.mark.parametrize("form", FORMS)
def test_before_it_nothing_is_changed_and_long_after_it_all_is(form: int) -> None:
    assert coulomb(29.999, change=0.5, form=form) == 1.0
    assert coulomb(1000.0, change=0.5, form=form) == pytest.approx(1.5)


def test_viscous_friction_changes_by_its_ratio() -> None:
    assert viscous(40.0, change=0.5) == 1.5
    assert viscous(40.0, change=0.5, viscous_ratio=0.2) == pytest.approx(1.1)
    assert viscous(40.0, change=0.5, viscous_ratio=0.0) == 1.0


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(t=st.floats(0.0, DURATION_S), change=st.floats(-0.95, 3.0), ratio=st.floats(0.0, 1.0))
def test_friction_stays_friction(form: int, t: float, change: float, ratio: float) -> None:
    assert coulomb(t, change=change, form=form) > 0.0
    assert viscous(t, change=change, viscous_ratio=ratio, form=form) > 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("t", [0.0, 31.0, 60.0])
def test_nothing_hidden_is_exactly_one(form: int, t: float) -> None:
    assert coulomb(t, form=form) == 1.0
    assert viscous(t, form=form) == 1.0
