"""The mean sign over a sample's cell, by hand."""

import numpy as np
import pytest

from friction_audit.effects.joint_data import mean_sign
from friction_audit.joint_log import Float

T: Float = np.arange(5, dtype=np.float64) * 0.01


def test_far_from_a_reversal_it_is_the_sign() -> None:
    np.testing.assert_array_equal(mean_sign(T, np.array([1.0, -1.0, 0.5, -0.2, 0.0]), np.zeros(5)), [1, -1, 1, -1, 0])


@pytest.mark.parametrize(("at_s", "expected"), [(0.0, 0.0), (0.002, -0.4), (-0.002, 0.4), (0.005, -1.0), (0.02, -1.0)])
def test_a_reversal_inside_the_cell_counts_for_its_part(at_s: float, expected: float) -> None:
    """Forwards after ``at_s``: of a cell of 10 ms, 5 ms - at_s are forwards."""
    acceleration = 3.0
    assert mean_sign(T, np.full(5, -acceleration * at_s), np.full(5, acceleration))[2] == pytest.approx(expected)


def test_one_sample_has_no_cell() -> None:
    assert mean_sign(np.zeros(1), np.array([-0.3]), np.array([9.0])) == pytest.approx([-1.0])
