"""A spring that stiffens evenly up to a torque."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.dynamics.transmission import bend_of, pushed, straightened


@pytest.mark.parametrize(
    ("straight", "torque"), [(0.0, 0.0), (2.0, 1.25), (4.0, 3.0), (6.0, 5.0), (-2.0, -1.25), (-6.0, -5.0)]
)
def test_by_hand(straight: float, torque: float) -> None:
    """Stiffening up to 3 N m, at the twist at which a straight spring would have 4."""
    bend, curve = bend_of(3.0)
    assert pushed(straight, bend, curve) == pytest.approx(torque)
    assert straightened(torque, bend) == pytest.approx(straight)


@pytest.mark.parametrize(("at", "slope"), [(0.0, 0.5), (2.0, 0.75), (4.0, 1.0), (9.0, 1.0)])
def test_it_is_half_as_stiff_without_torque_and_whole_at_the_torque_that_is_stated(at: float, slope: float) -> None:
    bend, curve = bend_of(3.0)
    step = 1e-6
    assert (pushed(at + step, bend, curve) - pushed(at, bend, curve)) / step == pytest.approx(slope, abs=1e-5)


def test_a_straight_spring_does_not_bend() -> None:
    assert pushed(-0.7, *bend_of(0.0)) == -0.7
    assert straightened(-0.7, 0.0) == -0.7
    assert straightened(0.0, 0.0) == 0.0


@given(st.floats(-1e3, 1e3), st.floats(0.0, 1e2))
def test_the_twist_under_a_torque_is_the_one_that_gives_it(torque: float, soft: float) -> None:
    bend, curve = bend_of(soft)
    straight = straightened(torque, bend)
    assert pushed(straight, bend, curve) == pytest.approx(torque, rel=1e-9, abs=1e-12)
    assert abs(torque) <= abs(straight) <= 2.0 * abs(torque)
