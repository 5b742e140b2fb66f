"""Curved viscous friction by hand, and its limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.model.terms.nonlinear_viscous import TERM
from tests.model.motion_by_hand import motion_of

SPEEDS = np.array([-2.0, -0.5, 0.0, 0.5, 1.0, 2.0])


@pytest.mark.parametrize("exponent", [0.5, 1.5, 2.0, 3.0])
def test_far_above_the_bend_it_is_a_power(exponent: float) -> None:
    column = TERM.regressor(motion_of(dq=SPEEDS), (exponent, 1e-6))[:, 0]
    assert column == pytest.approx(np.sign(SPEEDS) * np.abs(SPEEDS) ** exponent, rel=1e-9)


def test_far_below_the_bend_it_is_a_line() -> None:
    assert TERM.regressor(motion_of(dq=SPEEDS), (0.0, 1e3))[:, 0] == pytest.approx(SPEEDS, rel=1e-5)


def test_exponent_0_saturates() -> None:
    # dq / sqrt(v0^2 + dq^2), times sqrt(v0^2 + 1) so that it is 1 at 1 rad/s
    column = TERM.regressor(motion_of(dq=[0.75, 100.0]), (0.0, 1.0))[:, 0]
    assert column == pytest.approx([0.75 / 1.25 * np.sqrt(2.0), np.sqrt(2.0)], rel=1e-4)


@given(st.floats(-1.0, 5.0), st.floats(1e-6, 1e3))
def test_its_factor_is_the_torque_at_1_rad_per_s(exponent: float, speed: float) -> None:
    assert TERM.torque((0.3, exponent, speed), motion_of(dq=[1.0, -1.0])) == pytest.approx([0.3, -0.3])
