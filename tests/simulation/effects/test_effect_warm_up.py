import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.warm_up import (
    AMBIENT,
    SELF_HEATING,
    WarmUp,
    advance,
    coulomb_factor,
    temperature_c,
    viscous_factor,
)
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(WarmUp.forms))
warmths = st.floats(0.0, 10.0)


def test_ambient_is_63_percent_warm_after_the_time_constant_moving_or_not() -> None:
    group = pack([WarmUp(reduction=0.5, time_s=60.0, form=AMBIENT)])[0]
    for power in (0.0, 5.0):
        assert advance(group, 0.0, power, 60.0) == pytest.approx(1.0 - math.exp(-1.0))
        assert advance(group, 0.0, power, 1e6) == pytest.approx(1.0)


def test_self_heating_settles_where_heat_in_is_heat_out_and_cools_at_rest() -> None:
    group = pack([WarmUp(reduction=0.5, time_s=60.0, power_w=0.2, form=SELF_HEATING)])[0]
    assert advance(group, 0.0, 0.2, 1e6) == pytest.approx(1.0)
    assert advance(group, 0.0, 0.1, 1e6) == pytest.approx(0.5)
    assert advance(group, 1.0, 0.0, 60.0) == pytest.approx(math.exp(-1.0))


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(warmth=warmths, power=st.floats(0.0, 2.0), h=st.floats(0.0, 100.0))
def test_two_half_steps_make_a_step(form: int, warmth: float, power: float, h: float) -> None:
    group = pack([WarmUp(reduction=0.5, form=form)])[0]
    half = advance(group, warmth, power, 0.5 * h)
    assert advance(group, half, power, 0.5 * h) == pytest.approx(advance(group, warmth, power, h), abs=1e-12)


def test_a_warm_joint_has_lost_its_shares() -> None:
    group = pack([WarmUp(reduction=0.4, coulomb_ratio=0.5)])[0]
    assert viscous_factor(group, 1.0) == pytest.approx(0.6)
    assert viscous_factor(group, 0.5) == pytest.approx(math.sqrt(0.6))
    assert coulomb_factor(group, 1.0) == pytest.approx(0.8)
    assert coulomb_factor(group, 0.0) == viscous_factor(group, 0.0) == 1.0


@unhurried
@given(reduction=st.floats(0.0, 0.9), ratio=st.floats(0.0, 1.0), cold=warmths, warm=warmths)
def test_friction_falls_with_warmth_and_stays_friction(
    reduction: float, ratio: float, cold: float, warm: float
) -> None:
    group = pack([WarmUp(reduction=reduction, coulomb_ratio=ratio)])[0]
    cold, warm = sorted((cold, warm))
    assert coulomb_factor(group, cold) >= coulomb_factor(group, warm) > 0.0
    assert viscous_factor(group, cold) >= viscous_factor(group, warm) > 0.0


@pytest.mark.parametrize("warmth", [0.0, 0.3, 4.0])
def test_nothing_hidden_is_exactly_one(warmth: float) -> None:
    group = pack([WarmUp()])[0]
    assert coulomb_factor(group, warmth) == 1.0
    assert viscous_factor(group, warmth) == 1.0


def test_temperature_rises_with_warmth() -> None:
    temperature = temperature_c(WarmUp(cold_c=20.0, rise_k=10.0), np.array([0.0, 0.5, 1.0]))
    np.testing.assert_array_equal(temperature, [20.0, 25.0, 30.0])
