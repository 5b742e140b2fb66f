"""Waves by polynomials: those of the C library."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.model.waves import LARGEST, waves


def test_by_hand() -> None:
    assert_array_equal(waves(np.zeros(1)), [[1.0], [0.0]])
    quarters = np.linspace(-2.0 * np.pi, 2.0 * np.pi, 9)
    assert_allclose(waves(quarters)[0], [1, 0, -1, 0, 1, 0, -1, 0, 1], atol=1e-15)
    assert_allclose(waves(quarters)[1], [0, 1, 0, -1, 0, 1, 0, -1, 0], atol=1e-15)
    assert waves(np.zeros(0)).shape == (2, 0)


@pytest.mark.parametrize("size", [1e-9, 0.1, 1.0, 30.0, 1e3, 0.9 * LARGEST, 2.0 * LARGEST])
def test_as_those_of_the_c_library(size: float) -> None:
    angle = size * np.random.default_rng(0).uniform(-1.0, 1.0, 5000)
    assert_allclose(waves(angle), [np.cos(angle), np.sin(angle)], rtol=0.0, atol=3e-16)


def test_of_every_other_angle() -> None:
    angle = np.linspace(-7.0, 7.0, 3000)
    assert_array_equal(waves(angle[::2]), waves(angle)[:, ::2])


def test_what_is_no_number_stays_none() -> None:
    assert np.isnan(waves(np.array([0.0, np.nan]))[:, 1]).all()
