"""How far a gap closed, by hand."""

import numpy as np
import pytest

from friction_audit.diagnosis.validation import measure_gap

CYCLE = np.repeat([4, 7, 9], 100)
SIGN = np.tile([1.0, -1.0], 150)


def test_by_hand() -> None:
    gap = measure_gap(0.5 * SIGN, 0.2 * SIGN, 0.1, CYCLE)
    assert (gap.before, gap.after, gap.floor, gap.cycles) == pytest.approx((0.5, 0.2, 0.1, 3))
    assert gap.shrink == pytest.approx(0.75)
    assert gap.over_floor == pytest.approx(2.0)
    assert gap.shrink_se == pytest.approx(0.0, abs=1e-12)


def test_standard_error_is_that_of_leaving_out_each_cycle() -> None:
    rng = np.random.default_rng(0)
    before, after = rng.standard_normal(300), 0.5 * rng.standard_normal(300)
    gap = measure_gap(before, after, 0.2, CYCLE)
    without = np.array(
        [
            measure_gap(before[kept], after[kept], 0.2, CYCLE[kept]).shrink
            for kept in (np.not_equal(CYCLE, c) for c in (4, 7, 9))
        ]
    )
    assert gap.shrink_se == pytest.approx(np.sqrt(2 / 3 * np.sum((without - without.mean()) ** 2)))


def test_nothing_to_close_has_no_share() -> None:
    gap = measure_gap(0.1 * SIGN, 0.1 * SIGN, 0.1 + 1e-9, CYCLE)
    assert np.isnan(gap.shrink)
    assert gap.over_floor == pytest.approx(1.0)


def test_a_worse_model_shrinks_below_zero_and_no_floor_is_infinitely_far() -> None:
    gap = measure_gap(0.2 * SIGN, 0.3 * SIGN, 0.0, CYCLE)
    assert gap.shrink == pytest.approx(-0.5)
    assert gap.over_floor == float("inf")


def test_one_cycle_has_no_standard_error() -> None:
    assert np.isnan(measure_gap(SIGN, 0.5 * SIGN, 0.1, np.zeros(300, dtype=np.int64)).shrink_se)
