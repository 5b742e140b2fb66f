"""Rows made news: by hand, against the factor of the noise's covariance, and backwards."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from friction_audit.diagnosis.prewhitening import SlowNoise, prewhitening, response
from friction_audit.joint_log import Float

NOISE = SlowNoise(share=0.8, memory=7.0)


def scattered(seed: int, rows: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows with holes between them, of three kinds one after the other, and some of none."""
    rng = np.random.default_rng(seed)
    kind = np.sort(rng.integers(0, 3, rows))
    kind[rng.random(rows) < 0.1] = -1
    return np.sort(rng.choice(4 * rows, rows, replace=False)), kind


def covariance(noise: SlowNoise, place: NDArray[np.int64], kind: NDArray[np.int64]) -> Float:
    slow = noise.share * np.exp(-np.abs(place[:, None] - place) / noise.memory)
    together = (kind[:, None] == kind) & (kind >= 0)
    white = np.where(kind >= 0, 1.0 - noise.share, 1.0)
    return np.asarray(np.where(together, slow, 0.0) + np.diag(white))


def test_two_rows_by_hand() -> None:
    foretold = 0.8 * np.exp(-3.0 / 7.0)
    news = prewhitening(NOISE, np.array([4, 7]), np.zeros(2, np.int64)).of(np.array([2.0, 5.0]))
    assert news == pytest.approx([2.0, (5.0 - 2.0 * foretold) / np.sqrt(1.0 - foretold**2)])


@given(seed=st.integers(0, 1000), rows=st.integers(1, 60), share=st.floats(0.0, 0.98), memory=st.floats(0.5, 50.0))
def test_news_are_what_the_factor_of_the_covariance_leaves(seed: int, rows: int, share: float, memory: float) -> None:
    place, kind = scattered(seed, rows)
    noise, columns = SlowNoise(share=share, memory=memory), np.random.default_rng(seed).standard_normal((rows, 3))
    factor = np.linalg.cholesky(covariance(noise, place, kind))
    assert prewhitening(noise, place, kind).of(columns) == pytest.approx(np.linalg.solve(factor, columns), abs=1e-9)


def test_white_noise_is_news_already() -> None:
    place, kind = scattered(1, 40)
    column = np.random.default_rng(2).standard_normal(40)
    assert prewhitening(SlowNoise(share=0.0, memory=7.0), place, kind).of(column) == pytest.approx(column)


@given(seed=st.integers(0, 1000), rows=st.integers(1, 60))
def test_backwards_a_residual_has_the_products_of_its_news(seed: int, rows: int) -> None:
    news = prewhitening(NOISE, *scattered(seed, rows))
    columns, residual = np.random.default_rng(seed).standard_normal((2, rows))
    assert news.back(residual) @ columns == pytest.approx(residual @ news.of(columns))


def test_rows_of_one_kind_have_the_same_news_without_the_others() -> None:
    place, kind = scattered(3, 60)
    kept, column = kind == 1, np.random.default_rng(3).standard_normal(60)
    news = prewhitening(NOISE, place, kind)
    assert news.keep(kept).of(column[kept]) == pytest.approx(news.of(column)[kept])


def test_columns_stay_as_they_are_or_are_written_over() -> None:
    news = prewhitening(NOISE, *scattered(4, 30))
    columns = np.random.default_rng(4).standard_normal((2, 30)).T
    before = columns.copy()
    made = news.of(columns)
    assert np.array_equal(columns, before)
    news.in_place(columns)
    assert np.array_equal(columns, made)


def test_the_response_is_the_news_of_a_single_row() -> None:
    own = response(NOISE)
    rows = np.arange(400)
    late = prewhitening(NOISE, rows, np.zeros_like(rows)).of(np.where(rows == 300, 1.0, 0.0))[300:]
    assert own == pytest.approx(late[: len(own)], abs=1e-6)
    assert np.abs(late[len(own) :]).max() < 0.01
