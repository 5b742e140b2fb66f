import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.unlogged_compensation import (
    DEAD_BAND,
    SIGMOID,
    SMOOTH,
    UnloggedCompensation,
    torque_nm,
)
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(UnloggedCompensation.forms))


def torque(velocity: float, **numbers: float) -> float:
    return torque_nm(pack([UnloggedCompensation(**numbers)])[0], velocity)  # type: ignore[arg-type]


def test_smooth_is_a_tanh_and_a_line() -> None:
    expected = 0.7 * (0.2 * math.tanh(1.0) + 0.05 * 0.05)
    assert torque(0.05, share=0.7, form=SMOOTH) == pytest.approx(expected)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_dead_band_is_silent_inside_and_whole_outside(sign: float) -> None:
    assert torque(0.05 * sign, share=0.7, form=DEAD_BAND) == 0.0
    assert torque(0.1 * sign, share=0.7, form=DEAD_BAND) == pytest.approx(0.7 * (0.2 + 0.005) * sign)


def test_sigmoid_is_the_published_friction_of_the_first_joint_of_a_panda() -> None:
    # Gaz et al. (2019), joint 1: phi1 / (1 + exp(-phi2 (v + phi3))) - phi1 / (1 + exp(-phi2 phi3))
    phi1, phi2, phi3 = 0.54615, 5.1181, 0.039533
    numbers = {"share": 1.0, "coulomb_nm": 0.5 * phi1, "width_rad_s": 1.0 / phi2, "form": SIGMOID}
    for velocity in (-2.0, -0.1, 0.05, 1.0):
        published = phi1 / (1.0 + math.exp(-phi2 * (velocity + phi3))) - phi1 / (1.0 + math.exp(-phi2 * phi3))
        assert torque(velocity, **numbers) == pytest.approx(published, rel=0.02)


@pytest.mark.parametrize("velocity", [-1e6, 1e6])
def test_sigmoid_does_not_overflow(velocity: float) -> None:
    assert abs(torque(velocity, share=1.0, form=SIGMOID)) < 0.25


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(velocity=st.floats(-3.0, 3.0))
def test_it_helps_the_motion(form: int, velocity: float) -> None:
    assert torque(velocity, share=1.2, form=form) * velocity >= 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("velocity", [-1.0, 0.0, 0.02, 2.0])
def test_nothing_hidden_is_exactly_zero(form: int, velocity: float) -> None:
    assert torque(velocity, form=form) == 0.0
