import math

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.effects.gravity_error import GravityError, reading_nm

Q = np.array([0.0, math.pi / 2, -math.pi / 6])


def test_wrong_mass_and_tilted_base() -> None:
    assert_allclose(reading_nm(GravityError(torque_nm=0.3), Q), [0.0, 0.3, -0.15], atol=1e-15)
    assert_allclose(reading_nm(GravityError(torque_nm=0.3, phase_rad=math.pi / 2), Q[:2]), [0.3, 0.0], atol=1e-15)


def test_right_model_adds_nothing() -> None:
    assert_array_equal(reading_nm(GravityError(phase_rad=0.4), Q), 0.0)
