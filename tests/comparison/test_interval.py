"""Means, medians and their intervals."""

from math import inf, nan

import numpy as np
import pytest

from friction_audit.compensation.comparison.result import mean_interval, median_interval


def test_by_hand() -> None:
    # Student's t with 3 degrees of freedom: 3.182; standard deviation 1.291, over the root of 4.
    value, low, high = mean_interval([1.0, 2.0, 3.0, 4.0])
    assert value == 2.5
    assert high - value == pytest.approx(3.182446 * np.std([1, 2, 3, 4], ddof=1) / 2, rel=1e-6)
    assert value - low == pytest.approx(high - value)


def test_what_is_not_known_does_not_count() -> None:
    assert mean_interval([1.0, nan, 1.0]) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(("values", "mean"), [([], nan), ([nan], nan), ([2.0], 2.0)])
def test_too_few_have_no_interval(values: list[float], mean: float) -> None:
    interval = mean_interval(values)
    assert interval.value == pytest.approx(mean, nan_ok=True)
    assert np.isnan([interval.low, interval.high]).all()


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        # Tables of the binomial distribution: of 20 values the 6th and the 15th, of 6 the first and the last.
        (list(range(1, 21)), (10, 6, 15)),
        ([6, 5, 4, 3, 2, 1], (3, 1, 6)),
        ([2.0, 1.0, inf, inf, inf, inf, inf], (inf, 1.0, inf)),
        ([0.0, 0.0, 0.0, 1.0, inf, inf], (0.0, 0.0, inf)),
    ],
)
def test_medians_by_hand(values: list[float], expected: tuple[float, float, float]) -> None:
    assert median_interval(values) == expected
