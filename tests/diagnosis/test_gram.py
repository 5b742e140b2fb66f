"""Cross products of some columns are those of the whole matrix."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.diagnosis.cross_products import cross_products
from friction_audit.diagnosis.gram import SAMPLES_AT_A_TIME, fill_in, products_within
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.joint_log import Float


def arrays(n: int = 700) -> list[Float]:
    """A response, a base, three shapes in one array, one of its own, and one with its columns the other way round."""
    rng = np.random.default_rng(0)
    together = rng.standard_normal((3, 2, n))
    alone, other = rng.standard_normal((1, n)), rng.standard_normal((n, 3))
    return [rng.standard_normal(n), rng.standard_normal((n, 2)), *(one.T for one in together), alone.T, other]


def whole(columns: list[Float]) -> Float:
    return np.column_stack(columns)


@pytest.mark.parametrize("share", [None, 0.0, 0.3, 0.99])
def test_of_all_with_each_other(share: float | None) -> None:
    columns = arrays()
    kept = None if share is None else np.random.default_rng(1).random(700) < share
    used = whole(columns) if kept is None else whole(columns)[kept]
    assert_allclose(products_within(columns, kept), used.T @ used, rtol=1e-12, atol=1e-12)
    wanted = [0, 2, 5, 9, 12]
    gram = np.full((13, 13), np.nan)
    fill_in(gram, columns, wanted, kept)
    assert_allclose(gram[wanted], (used.T @ used)[wanted], rtol=1e-12, atol=1e-12)
    assert_allclose(gram.T[wanted], gram[wanted], rtol=1e-12, atol=1e-12)
    assert np.isnan(gram[1, 3])


def test_over_more_samples_than_are_taken_at_a_time() -> None:
    columns = arrays(3 * SAMPLES_AT_A_TIME + 7)
    kept = np.ones(len(columns[0]), bool)
    kept[[0, 100, 5000]] = False
    used = whole(columns)[kept]
    assert_allclose(products_within(columns, kept), used.T @ used, rtol=1e-11, atol=1e-9)


def test_what_was_known_is_taken_and_the_rest_is_added() -> None:
    columns = arrays()
    mixed = [columns[5], *columns[2:5], columns[6]]
    every = whole(mixed)
    known = np.full((10, 10), np.nan)
    known[1:7, 1:7] = every.T[1:7] @ every[:, 1:7]
    assert_allclose(products_within(mixed, None, known), every.T @ every, rtol=1e-12, atol=1e-12)
    known[1:7, 1:7] = 0.0
    assert_array_equal(products_within(mixed, None, known)[1:7, 1:7], 0.0)


def test_only_products_with_columns_that_lack_one_are_computed() -> None:
    columns = arrays()
    every = whole(columns)
    gram = every.T @ every
    gram[3:5, 9], gram[9, 3:5] = np.nan, np.nan
    gram[3, 0] = 7.0
    scale = np.arange(1.0, 14.0)
    expected = every.T @ every / (scale[:, None] * scale)
    gram /= scale[:, None] * scale
    fill_in(gram, columns, [3, 4], None, scale)
    assert_allclose(gram[[3, 4], 9], expected[[3, 4], 9], rtol=1e-12)
    assert_allclose(gram[9, [3, 4]], expected[9, [3, 4]], rtol=1e-12)
    assert gram[3, 0] == 7.0 / 4.0


def test_a_search_fills_in_what_it_asks_for() -> None:
    y, base, *shapes = arrays()
    groups = [Group(name=str(k), shapes=(shape,)) for k, shape in enumerate(shapes)]
    products = cross_products(y, base, groups)
    every = whole([y, base, *shapes])
    every /= np.sqrt(np.mean(every**2, axis=0))
    gram = every.T @ every
    assert_allclose(products.gram[:3], gram[:3], rtol=1e-11, atol=1e-10)
    assert np.isnan(products.gram[3, 5])
    assert np.isfinite(Ranking(products, 700.0).rss([0, 1, 3, 4]))
    products.fill([0, 4])
    assert_allclose(products.gram[[3, 4, 10, 11, 12]], gram[[3, 4, 10, 11, 12]], rtol=1e-11, atol=1e-10)
    products.fill(range(5))
    assert_allclose(products.gram, gram, rtol=1e-11, atol=1e-10)


def test_products_of_an_earlier_search_serve_a_later_one() -> None:
    y, base, *shapes = arrays()
    first = cross_products(y, base, [Group(name="one", shapes=tuple(shapes[:3]))])
    groups = [Group(name="one", shapes=(*shapes[:3], shapes[3])), Group(name="two", shapes=(shapes[4],))]
    first.fill([0, 2])
    fresh, later = cross_products(y, base, groups), cross_products(y, base, groups, None, first)
    assert np.isfinite(later.gram[3:5, 5:9]).all()
    fresh.fill(range(5))
    later.fill(range(5))
    assert_allclose(later.gram, fresh.gram, rtol=1e-11, atol=1e-10)
    assert later.trials == pytest.approx(fresh.trials)


def test_rows_of_one_array_as_columns() -> None:
    both = np.random.default_rng(3).standard_normal((2, 50))
    columns = [row[:, None] for row in both]
    assert_allclose(products_within(columns, None), both @ both.T)
    gram = np.full((2, 2), np.nan)
    fill_in(gram, columns, [1], None)
    assert_allclose(gram[1], (both @ both.T)[1])
