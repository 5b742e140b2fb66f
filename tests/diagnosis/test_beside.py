"""One effect beside columns that stay: the same factors and the same rest as of everything fitted together."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.nominal_model import least_squares


def test_by_hand() -> None:
    beside = Beside(np.ones((4, 1)), np.array([0.0, 0.0, 1.0, 3.0]))
    factors, left = beside.fit(np.array([[0.0], [0.0], [1.0], [1.0]]))
    assert beside.without == pytest.approx(6.0)
    assert_allclose(factors, [2.0])
    assert left == pytest.approx(2.0)


@pytest.mark.parametrize("seed", range(5))
def test_as_everything_fitted_together(seed: int) -> None:
    rng = np.random.default_rng(seed)
    columns, own, y = rng.standard_normal((300, 4)), rng.standard_normal((300, 2)), rng.standard_normal(300)
    columns[:, 3] = 1e6 * columns[:, 1]  # a copy in another unit
    own[:, 0] += columns[:, 0]
    together = np.hstack([columns, 1e-5 * own])
    every = least_squares(together, y)
    factors, left = Beside(columns, y).fit(1e-5 * own)
    assert_allclose(factors, every[4:], rtol=1e-9)
    assert left == pytest.approx(float(np.sum((y - together @ every) ** 2)), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_column_of_zeros_has_no_factor_not_even_a_rounding(seed: int) -> None:
    rng = np.random.default_rng(seed)
    own = rng.standard_normal((50, 5))
    own[:, [1, 3]] = 0.0
    factors, _ = Beside(rng.standard_normal((50, 3)), rng.standard_normal(50)).fit(own)
    assert factors[[1, 3]].tolist() == [0.0, 0.0]


def test_a_copy_adds_nothing() -> None:
    rng = np.random.default_rng(0)
    columns, y = rng.standard_normal((50, 3)), rng.standard_normal(50)
    beside = Beside(columns, y)
    factors, left = beside.fit(columns @ np.array([[1.0], [2.0], [-1.0]]))
    assert_allclose(factors, [0.0])
    assert left == pytest.approx(beside.without, rel=1e-12)


def test_nothing_to_stand_beside() -> None:
    y = np.array([1.0, 2.0])
    factors, left = Beside(np.zeros((2, 0)), y).fit(y[:, None] / 2.0)
    assert_allclose(factors, [2.0])
    assert left == pytest.approx(0.0, abs=1e-20)


def test_what_is_left_is_what_the_sum_of_squares_is_of() -> None:
    rng = np.random.default_rng(1)
    columns, own, y = rng.standard_normal((60, 3)), rng.standard_normal((60, 2)), rng.standard_normal(60)
    beside = Beside(columns, y)
    left = beside.left(own)
    assert_allclose(np.hstack([columns, own]).T @ left, 0.0, atol=1e-12)
    assert float(left @ left) == pytest.approx(beside.fit(own)[1], rel=1e-12)
    assert_allclose(beside.left(own[:, :0]), beside.response)


def test_factors_that_would_be_below_zero_are_left_out() -> None:
    beside = Beside(np.ones((3, 1)), np.array([0.0, -1.0, 1.0]))
    rising, falling = np.array([[0.0], [0.5], [1.0]]), np.array([[1.0], [0.5], [0.0]])
    assert beside.left_above_zero(falling) == pytest.approx(beside.without)
    assert beside.left_above_zero(rising) == pytest.approx(beside.fit(rising)[1])
    assert beside.left_above_zero(np.hstack([falling, rising])) == pytest.approx(1.5)


def test_fewer_samples_than_columns() -> None:
    rng = np.random.default_rng(2)
    own, y = rng.standard_normal((3, 5)), rng.standard_normal(3)
    factors, left = Beside(np.zeros((3, 0)), y).fit(own)
    assert_allclose(own @ factors, y)
    assert left == pytest.approx(0.0, abs=1e-20)
