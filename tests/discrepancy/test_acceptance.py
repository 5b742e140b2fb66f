"""Whether an effect holds on locked cycles: against statsmodels and explicit refits, and calibrated."""

import numpy as np
import pytest
from scipy.stats import binom, ttest_1samp
from statsmodels.api import OLS

from friction_audit.discrepancy.acceptance import cycle_rss, paired_improvement, rms_gain, stability
from friction_audit.errors import AnalysisError
from tests.discrepancy.synthetic_columns import synthetic_columns


def test_residuals_are_summed_by_cycle() -> None:
    assert cycle_rss(np.array([1.0, 2.0, 3.0, 4.0]), np.array([5, 2, 5, 2])).tolist() == [20.0, 10.0]


def test_paired_improvement_is_a_t_test_over_cycles() -> None:
    rng = np.random.default_rng(0)
    model = rng.uniform(1, 2, 15)
    without = model + rng.normal(0.1, 0.2, (2, 15))
    outcome = paired_improvement(without, model, rng)
    single = ttest_1samp(without - model, 0.0, axis=1, alternative="greater")
    assert outcome.t == pytest.approx(single.statistic)


def test_p_value_of_one_effect_is_about_that_of_the_t_test() -> None:
    rng = np.random.default_rng(0)
    d = rng.normal(0.1, 0.2, (1, 25))
    outcome = paired_improvement(1.0 + d, np.ones(25), rng, draws=9999)
    assert outcome.adjusted_p[0] == pytest.approx(ttest_1samp(d[0], 0.0, alternative="greater").pvalue, abs=0.01)


def test_no_improvement_is_accepted_no_more_often_than_allowed() -> None:
    hits = 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        common = rng.standard_normal(14)
        without = 1.0 + rng.standard_normal((3, 14)) + common
        outcome = paired_improvement(without, np.ones(14), rng, draws=199)
        hits += outcome.adjusted_p.min() <= 0.05
    assert hits <= binom.ppf(0.999, 300, 0.05)


def test_a_clear_improvement_is_accepted() -> None:
    rng = np.random.default_rng(1)
    model = rng.uniform(1, 2, 20)
    outcome = paired_improvement(np.stack([model + 1 + rng.normal(0, 0.3, 20), model]), model, rng)
    assert outcome.adjusted_p[0] < 0.01
    assert outcome.adjusted_p[1] > 0.3


def test_two_locked_cycles_are_refused() -> None:
    with pytest.raises(AnalysisError, match="locked cycles: 2, expected at least 3"):
        paired_improvement(np.ones((1, 2)), np.ones(2), np.random.default_rng(0))


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
