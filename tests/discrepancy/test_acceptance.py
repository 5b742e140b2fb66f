"""Whether an effect holds on locked cycles: against statsmodels and explicit refits, and calibrated."""

import numpy as np
import pytest
from scipy.stats import binom, ttest_1samp
from statsmodels.api import OLS
from statsmodels.stats.multitest import multipletests

from friction_audit.discrepancy.acceptance import (
    LEAST_GAIN,
    cycle_rss,
    holm,
    null_gain,
    paired_improvement,
    rms_gain,
    stability,
)
from friction_audit.discrepancy.omnibus import bootstrap_weights
from friction_audit.errors import AnalysisError
from tests.discrepancy.synthetic_columns import SyntheticColumns, synthetic_columns


def test_holm_is_that_of_statsmodels() -> None:
    p = np.array([0.01, 0.04, 0.03, 0.5, 0.002])
    assert holm(p) == pytest.approx(multipletests(p, method="holm")[1])


def test_residuals_are_summed_by_cycle() -> None:
    assert cycle_rss(np.array([1.0, 2.0, 3.0, 4.0]), np.array([5, 2, 5, 2])).tolist() == [20.0, 10.0]


def test_paired_improvement_is_a_t_test_over_cycles() -> None:
    rng = np.random.default_rng(0)
    model = rng.uniform(1, 2, 15)
    without = model + rng.normal(0.1, 0.2, (2, 15))
    outcome = paired_improvement(without, model, rng, method="holm")
    single = ttest_1samp(without - model, 0.0, axis=1, alternative="greater")
    assert outcome.t == pytest.approx(single.statistic)
    assert outcome.adjusted_p == pytest.approx(multipletests(single.pvalue, method="holm")[1])


@pytest.mark.parametrize("method", ["max_t", "holm"])
def test_no_improvement_is_accepted_no_more_often_than_allowed(method: str) -> None:
    hits = 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        common = rng.standard_normal(14)
        without = 1.0 + rng.standard_normal((3, 14)) + common
        outcome = paired_improvement(
            without, np.ones(14), rng, method="holm" if method == "holm" else "max_t", draws=199
        )
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


def locked_gain(data: SyntheticColumns, y: np.ndarray, w: np.ndarray, locked: np.ndarray) -> float:
    rss = []
    for columns in (data.base, np.hstack([data.base, w])):
        factors = np.linalg.lstsq(columns[~locked], y[~locked], rcond=None)[0]
        rss.append(np.sum((y - columns @ factors)[locked] ** 2))
    return rms_gain(*rss)


def test_null_gain_equals_explicit_refits() -> None:
    data = synthetic_columns(np.random.default_rng(2), cycles=20, memory=0.9)
    locked = data.cycle >= 13
    w = [data.groups[0].shapes[0], data.groups[5].shapes[1]]
    answer = null_gain(data.noise, data.base, w, data.cycle, locked, np.random.default_rng(3), draws=20, quantile=1.0)
    draws = bootstrap_weights(np.random.default_rng(3), 20, 20)
    by_hand = [LEAST_GAIN]
    for columns in w:
        full = np.hstack([data.base, columns])
        e = data.noise - full @ np.linalg.lstsq(full[~locked], data.noise[~locked], rcond=None)[0]
        by_hand += [locked_gain(data, g[data.cycle] * e, columns, locked) for g in draws]
    assert answer == pytest.approx(max(by_hand))


def test_gain_by_chance_stays_below_the_null_and_that_of_a_real_effect_above() -> None:
    chance, real = 0, 0
    for seed in range(200):
        data = synthetic_columns(np.random.default_rng([seed, 4]), cycles=20, memory=0.9, per_cycle=60)
        w, locked = data.groups[0].shapes[0], data.cycle % 3 == 0
        null = null_gain(data.noise, data.base, [w], data.cycle, locked, np.random.default_rng(seed), draws=199)
        chance += locked_gain(data, data.noise, w, locked) > null
        real += locked_gain(data, data.noise + data.partial(0, 0), w, locked) > null
    assert chance <= binom.ppf(0.999, 200, 0.05)
    assert real >= 190


def test_the_null_is_the_same_whether_the_effect_is_there_or_not() -> None:
    data = synthetic_columns(np.random.default_rng(9), cycles=20, memory=0.5)
    w, locked = data.groups[5].shapes[0], data.cycle >= 14
    pair = [
        null_gain(y, data.base, [w], data.cycle, locked, np.random.default_rng(1), draws=99)
        for y in (data.noise, data.noise + w @ [1.0, 2.0])
    ]
    assert pair[0] == pytest.approx(pair[1])


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
