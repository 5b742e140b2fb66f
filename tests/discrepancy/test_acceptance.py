"""Strength of an effect in parts of a log: against statsmodels and by hand."""

import numpy as np
import pytest
from statsmodels.api import OLS

from friction_audit.discrepancy.acceptance import rms_gain, stability
from tests.discrepancy.synthetic_columns import synthetic_columns


def test_rms_gain_by_hand() -> None:
    assert rms_gain(4.0, 1.0) == pytest.approx(0.5)
    assert rms_gain(0.0, 0.0) == 0.0


def test_strength_in_a_part_is_cluster_robust_least_squares() -> None:
    data = synthetic_columns(np.random.default_rng(5), cycles=24, memory=0.5)
    effect = data.groups[5].shapes[0]
    y = data.noise + effect @ [0.5, 0.2]
    part = (data.cycle >= 12).astype(np.int64)
    outcome = stability(y, data.base, effect, data.cycle, part)
    whole = OLS(y, np.hstack([data.base, effect])).fit()
    columns = np.column_stack([data.base, effect @ whole.params[3:]])[part == 1]
    fit = OLS(y[part == 1], columns).fit(
        cov_type="cluster", cov_kwds={"groups": data.cycle[part == 1], "use_correction": False}
    )
    assert outcome.strength[1] == pytest.approx(fit.params[3])
    assert outcome.se[1] == pytest.approx(fit.bse[3] * np.sqrt(12 / 11))


def test_an_effect_of_the_whole_log_is_stable_and_one_of_its_first_half_is_not() -> None:
    data = synthetic_columns(np.random.default_rng(6), cycles=30, memory=0.5)
    w = data.groups[0].shapes[0]
    half = (data.cycle >= 15).astype(np.int64)
    assert stability(data.noise + 0.5, data.base, w, data.cycle, half).stable()
    assert not stability(data.noise + 0.5 * (half == 0), data.base, w, data.cycle, half).stable()


def test_parts_that_cannot_show_an_effect_say_nothing() -> None:
    data = synthetic_columns(np.random.default_rng(7), cycles=30, memory=0.5)
    early = data.cycle < 15
    w = np.where(early, 1.0, 0.0)[:, None]
    outcome = stability(data.noise + w[:, 0], data.base, w, data.cycle, (~early).astype(np.int64))
    assert np.isnan(outcome.strength).tolist() == [False, True]
    assert np.isnan(outcome.p_value)
    assert outcome.stable()


def test_weights_of_samples_are_those_of_least_squares() -> None:
    data = synthetic_columns(np.random.default_rng(8), cycles=24, memory=0.0)
    w, keep = data.groups[0].shapes[0], data.cycle != 5
    y = data.noise + 0.5
    part = (data.cycle >= 12).astype(np.int64)
    weighted = stability(y, data.base, w, data.cycle, part, keep.astype(float))
    without = stability(y[keep], data.base[keep], w[keep], data.cycle[keep], part[keep])
    assert weighted.strength == pytest.approx(without.strength)
