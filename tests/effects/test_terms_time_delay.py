"""A delay by hand: exact where the step is the delay, jumps included."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.terms.time_delay import TERM
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

T = np.arange(0.0, 10.0, 0.0025)
ZERO = np.zeros_like(T)


def with_rest(rest: Float) -> Motion:
    return Motion(t=T, q=ZERO, dq=ZERO, ddq=ZERO, rest=rest)


@pytest.mark.parametrize("delay", [0.01, -0.02])
def test_the_torque_of_a_delay_moves_a_jump_as_a_whole(delay: float) -> None:
    jump = np.sign(np.sin(T)) + 0.3 * np.sin(2.0 * T)
    late = np.interp(T - delay, T, jump)
    assert_allclose(jump + TERM.torque((delay, delay, 0.0), with_rest(jump)), late, atol=1e-12)


def test_a_load_is_late_with_the_rest_only_where_it_is_asked_for() -> None:
    moved = replace(with_rest(np.sin(T)), load=3.0 * np.cos(2.0 * T))
    late = np.sin(T - 0.01) + 3.0 * np.cos(2.0 * (T - 0.01))
    assert_allclose(
        TERM.torque((0.01, 0.01, 1.0), moved)[4:], (late - np.sin(T) - 3.0 * np.cos(2.0 * T))[4:], atol=1e-4
    )
    assert_array_equal(TERM.torque((0.01, 0.01, 0.0), moved), TERM.torque((0.01, 0.01, 0.0), with_rest(np.sin(T))))


def test_a_short_step_is_minus_the_derivative() -> None:
    column = TERM.regressor(with_rest(np.sin(2.0 * T)), (1e-4, 0.0))[:, 0]
    assert_allclose(column[1:-1], -2.0 * np.cos(2.0 * T)[1:-1], atol=0.01)


def test_no_delay_is_nothing_and_without_a_torque_to_delay_it_says_so() -> None:
    assert_array_equal(TERM.torque((0.0, 0.01, 0.0), with_rest(np.sin(T))), 0.0)
    with pytest.raises(AnalysisError, match="no torque of inertia and friction"):
        TERM.regressor(Motion(t=T, q=ZERO, dq=ZERO, ddq=ZERO), (0.01, 0.0))
