"""The published static friction of the Panda."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from friction_audit.compensation.compensators.model_based import PUBLISHED, fit_sigmoid
from friction_audit.errors import UsageError
from tests.compensation.competitor_bench import feed

FORWARD = (0.25, 0.39, 0.39, 0.58, 0.37, 0.18, 0.28)
BACKWARD = (0.30, 0.49, 0.25, 0.70, 0.47, 0.12, 0.29)


def test_plateaus_are_the_published_ones() -> None:
    assert_allclose([one.plateaus_nm[0] for one in PUBLISHED], FORWARD, atol=6e-3)
    assert_allclose([one.plateaus_nm[1] for one in PUBLISHED], BACKWARD, atol=6e-3)


@pytest.mark.parametrize("joint", range(7))
def test_the_torque_is_the_formula(joint: int) -> None:
    one = PUBLISHED[joint]
    dq = np.array([-10.0, -0.3, -0.05, 0.0, 0.05, 0.3, 10.0])
    phi1, phi2, phi3 = one.height_nm, one.steepness_s_per_rad, one.shift_rad_s
    expected = phi1 / (1 + np.exp(-phi2 * (dq + phi3))) - phi1 / (1 + np.exp(-phi2 * phi3))
    torque, _ = feed(one, dq, 0.0)
    assert_allclose(torque, expected, atol=1e-12)
    assert torque[3] == 0.0
    assert_allclose(torque[[-1, 0]], [one.plateaus_nm[0], -one.plateaus_nm[1]], rtol=1e-9)


@given(coulomb=st.floats(0.01, 2.0), share=st.floats(-0.9, 0.9))
def test_a_step_is_fitted_by_a_steep_sigmoid(coulomb: float, share: float) -> None:
    offset = share * coulomb
    forward, backward = fit_sigmoid(coulomb, 0.0, offset_nm=offset, steepness_s_per_rad=1e3).plateaus_nm
    assert forward == pytest.approx(coulomb + offset, rel=0.02, abs=0.02 * coulomb)
    assert backward == pytest.approx(coulomb - offset, rel=0.02, abs=0.02 * coulomb)


def test_what_cannot_be_fitted_is_refused() -> None:
    with pytest.raises(UsageError, match="friction above zero"):
        fit_sigmoid(0.0, 0.0)
    with pytest.raises(UsageError, match="offset"):
        fit_sigmoid(0.3, 0.0, offset_nm=1.0)
