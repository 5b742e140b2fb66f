import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.nonlinear_viscous import ARCTAN, CUBIC, EYRING, NonlinearViscous, extra_nm
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(NonlinearViscous.forms))
speeds = st.floats(0.0, 5.0)


def extra(speed: float, **numbers: float) -> float:
    return extra_nm(pack([NonlinearViscous(**numbers)])[0], speed)  # type: ignore[arg-type]


@pytest.mark.parametrize("form", FORMS)
def test_every_form_has_its_size_at_the_reference_speed(form: int) -> None:
    assert extra(1.5, torque_nm=0.2, speed_rad_s=1.5, form=form) == pytest.approx(0.2)


@pytest.mark.parametrize(("exponent", "share"), [(0.5, math.sqrt(2.0)), (2.0, 4.0)])
def test_power_at_twice_the_reference_speed(exponent: float, share: float) -> None:
    assert extra(2.0, torque_nm=0.2, exponent=exponent) == pytest.approx(0.2 * share)


def test_cubic_at_twice_the_reference_speed_is_eight_times_as_large() -> None:
    assert extra(2.0, torque_nm=0.2, form=CUBIC) == pytest.approx(1.6)


def test_shear_thinning_grows_like_a_logarithm_and_arctan_to_a_limit() -> None:
    decades = [extra(speed, torque_nm=1.0, form=EYRING) for speed in (10.0, 100.0, 1000.0)]
    assert decades[2] - decades[1] == pytest.approx(decades[1] - decades[0], rel=1e-3)
    assert extra(1e9, torque_nm=1.0, form=ARCTAN) == pytest.approx(0.5 * math.pi / math.atan(10.0))


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(slow=speeds, fast=speeds)
def test_it_grows_with_speed_and_never_drives(form: int, slow: float, fast: float) -> None:
    slow, fast = sorted((slow, fast))
    assert extra(fast, torque_nm=0.2, form=form) >= extra(slow, torque_nm=0.2, form=form) >= 0.0


@pytest.mark.parametrize("form", FORMS)
def test_there_is_none_of_it_at_rest(form: int) -> None:
    assert extra(0.0, torque_nm=0.2, form=form) == 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("speed", [0.0, 0.3, 4.0])
def test_nothing_hidden_is_exactly_zero(form: int, speed: float) -> None:
    assert extra(speed, form=form) == 0.0
