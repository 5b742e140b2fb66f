import numpy as np
from numpy.testing import assert_array_equal

from friction_audit.simulation.effects.torque_bias import TorqueBias, reading_nm

T = np.array([0.0, 1e-3, 2e-3, 3e-3, 4e-3])


def test_same_at_all_times() -> None:
    assert_array_equal(reading_nm(TorqueBias(torque_nm=-0.1), T), [-0.1] * 5)


def test_sensor_at_zero_adds_nothing() -> None:
    assert_array_equal(reading_nm(TorqueBias(), T), 0.0)
