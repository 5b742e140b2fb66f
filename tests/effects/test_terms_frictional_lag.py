"""Friction at a lagged speed by hand: a steady speed, a steady acceleration, a direction that does not lag."""

import numpy as np
from numpy.testing import assert_allclose

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.terms.frictional_lag import TERM, lagged
from friction_audit.joint_log import Float

T = np.arange(0.0, 8.0, 0.0025)
COULOMB, VISCOUS = 0.4, 0.2


def moving(dq: Float) -> Motion:
    ddq = np.gradient(dq, T)
    rest = 0.3 * ddq + COULOMB * np.sign(dq) + VISCOUS * dq
    return Motion(t=T, q=np.cumsum(dq) * 0.0025, dq=dq, ddq=ddq, rest=rest)


def test_the_lag_of_a_ramp_is_its_slope_times_the_time() -> None:
    assert_allclose((2.0 * T - lagged(2.0 * T, 0.0025, 0.1))[-100:], 0.2, rtol=0.02)


def test_viscous_friction_at_a_steady_acceleration() -> None:
    motion = moving(-(0.1 + 0.5 * T + 0.01 * np.sin(5.0 * T)))
    torque = TERM.torque((1.0, 0.1, 0.0, 0.1), motion)
    # Speed is seen 0.5 * 0.1 too low, so that friction, against the motion, is less.
    assert abs(np.mean(torque[-1000:]) - VISCOUS * 0.05) < 1e-3


def test_at_a_steady_speed_and_with_no_share_nothing_lags() -> None:
    steady = moving(np.where(T < 2.0, 0.5 * T + 0.1, 1.1))
    assert_allclose(TERM.regressor(steady, (0.05, 1.0, 0.3))[-1000:], 0.0, atol=1e-9)
    assert not TERM.torque((0.0, 0.05, 1.0, 0.3), moving(np.sin(T))).any()


def test_stribeck_friction_lags_with_coulomb_friction_as_its_unit() -> None:
    dq = 0.5 + 0.4 * np.sin(2.0 * T)
    column = TERM.regressor(moving(dq), (0.1, 0.5, 0.2))[:, 0]
    seen = lagged(dq, 0.0025, 0.1)
    expected = VISCOUS * (seen - dq) + 0.5 * COULOMB * (np.exp(-seen / 0.2) - np.exp(-dq / 0.2))
    assert_allclose(column, expected, atol=1e-6)
