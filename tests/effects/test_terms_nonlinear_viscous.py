"""Curved viscous friction by hand, and its limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.effects.terms.nonlinear_viscous import TERM, bend
from friction_audit.joint_log import Float
from tests.effects.motion_by_hand import motion_of

SPEEDS = np.array([-2.0, -0.5, 0.0, 0.5, 1.0, 2.0])
PACE = np.linspace(0.0, 6.0, 50)
ANGLE = np.arctan(PACE / np.sqrt(2.0))
"""Of t = sqrt(2) times the pace, four degrees of freedom: tan = t / 2."""


@pytest.mark.parametrize("exponent", [0.5, 1.5, 2.0, 3.0])
def test_far_above_the_bend_it_is_a_power(exponent: float) -> None:
    column = TERM.regressor(motion_of(dq=SPEEDS), (exponent, 1e-6, 0.0))[:, 0]
    assert column == pytest.approx(np.sign(SPEEDS) * np.abs(SPEEDS) ** exponent, rel=1e-9)


def test_far_below_the_bend_it_is_a_line() -> None:
    assert TERM.regressor(motion_of(dq=SPEEDS), (0.0, 1e3, 0.0))[:, 0] == pytest.approx(SPEEDS, rel=1e-5)


def test_exponent_0_saturates() -> None:
    # dq / sqrt(v0^2 + dq^2), times sqrt(v0^2 + 1) so that it is 1 at 1 rad/s
    column = TERM.regressor(motion_of(dq=[0.75, 100.0]), (0.0, 1.0, 0.0))[:, 0]
    assert column == pytest.approx([0.75 / 1.25 * np.sqrt(2.0), np.sqrt(2.0)], rel=1e-4)


@pytest.mark.parametrize(
    ("freedom", "expected"),
    [
        (1.0, 2.0 / np.pi * np.arctan(np.sqrt(2.0) * PACE)),
        (2.0, PACE / np.sqrt(1.0 + PACE**2)),
        (4.0, np.sin(ANGLE) * (1.0 + np.cos(ANGLE) ** 2 / 2.0)),  # Student's t with four degrees of freedom
    ],
)
def test_bends_that_have_a_formula(freedom: float, expected: Float) -> None:
    assert bend(PACE, freedom) == pytest.approx(expected, abs=1e-6)


def test_the_sharpness_of_tanh_is_tanh() -> None:
    assert bend(PACE / np.sqrt(2.0) / 0.775, 7.0) == pytest.approx(np.tanh(PACE), abs=2e-3)


def test_a_sharpness_of_almost_0_is_that_of_0() -> None:
    at = motion_of(dq=SPEEDS)
    assert TERM.regressor(at, (0.7, 0.3, 1e-9)) == pytest.approx(TERM.regressor(at, (0.7, 0.3, 0.0)), abs=1e-6)


def test_a_bend_below_all_speeds_is_coulomb_friction() -> None:
    assert TERM.regressor(motion_of(dq=SPEEDS), (0.0, 1e-6, 1.5))[:, 0] == pytest.approx(np.sign(SPEEDS), abs=1e-9)


@given(st.floats(-1.0, 5.0), st.floats(1e-6, 1e3), st.floats(-0.7, 4.0))
def test_its_factor_is_the_torque_at_1_rad_per_s(exponent: float, speed: float, sharpness: float) -> None:
    assert TERM.torque((0.3, exponent, speed, sharpness), motion_of(dq=[1.0, -1.0])) == pytest.approx([0.3, -0.3])
