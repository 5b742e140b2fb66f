"""The test that something is missing: by hand, against explicit refits and statsmodels, and calibrated."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import beta, binom
from statsmodels.api import OLS
from statsmodels.stats.sandwich_covariance import S_crosssection

from friction_audit.diagnosis.cycle_scores import CycleScores, marginal_evidence
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.omnibus import (
    FEW_CYCLES,
    WEBB,
    balanced,
    bootstrap_weights,
    independent_clusters,
    neighbours_remember,
    omnibus_test,
    step_down,
)
from friction_audit.errors import AnalysisError
from tests.diagnosis.synthetic_columns import synthetic_columns

SETS = 200


def rejections(cycles: int, memory: float, size: float = 0.0, sets: int = SETS) -> int:
    count = 0
    for seed in range(sets):
        rng = np.random.default_rng([seed, cycles])
        data = synthetic_columns(rng, cycles=cycles, memory=memory, per_cycle=60)
        y = data.noise + size * data.partial(seed % 12, 0)
        cluster = independent_clusters(data.cycle, len(y) / data.n_eff)
        remember = neighbours_remember(cluster, len(y) / data.n_eff)
        outcome = omnibus_test(y, data.base, data.groups, cluster, rng, draws=199, remember=remember)
        count += outcome.p_value <= 0.05
    return count


@pytest.mark.parametrize(
    ("cycles", "memory"),
    [
        pytest.param(12, 0.0, marks=pytest.mark.thorough),
        (12, 0.98),
        pytest.param(24, 0.9, marks=pytest.mark.thorough),
        pytest.param(60, 0.98, marks=pytest.mark.thorough),
    ],
)
def test_nothing_is_found_in_noise_more_often_than_allowed(cycles: int, memory: float) -> None:
    assert rejections(cycles, memory) <= binom.ppf(0.999, SETS, 0.05)


def test_an_effect_of_a_fifth_of_the_noise_is_found() -> None:
    assert rejections(40, 0.5, 0.2, 60) >= 54  # worth 800 samples: n_eff rho^2 = 32


def brute_force(y: np.ndarray, base: np.ndarray, w: np.ndarray, cycle: np.ndarray, g: np.ndarray) -> float:
    """The statistic of one draw by an explicit refit."""
    e = y - base @ np.linalg.lstsq(base, y, rcond=None)[0]
    drawn = g[cycle] * e
    drawn = drawn - base @ np.linalg.lstsq(base, drawn, rcond=None)[0]
    free = w - base @ np.linalg.lstsq(base, w, rcond=None)[0]
    s = np.stack([free[cycle == c].T @ drawn[cycle == c] for c in range(cycle.max() + 1)])
    return float(s.sum(axis=0) @ np.linalg.solve(s.T @ s, s.sum(axis=0)))


@pytest.mark.parametrize("index", [0, 5])
def test_draws_from_sums_over_cycles_equal_explicit_refits(index: int) -> None:
    data = synthetic_columns(np.random.default_rng(1), cycles=20, memory=0.5)
    group = replace(data.groups[index], shapes=data.groups[index].shapes[:1])
    width = group.shapes[0].shape[1]
    outcome = omnibus_test(data.noise, data.base, [group], data.cycle, np.random.default_rng(5), draws=19)
    weights = bootstrap_weights(np.random.default_rng(5), 19, 20)
    by_hand = [brute_force(data.noise, data.base, group.shapes[0], data.cycle, g) for g in [np.ones(20), *weights]]
    expected = marginal_evidence(np.array(by_hand), 20, width)
    observed, drawn = CycleScores(data.noise, data.base, data.cycle, 20, weights).largest(group)
    np.testing.assert_allclose([observed, *drawn], expected, rtol=1e-6)
    assert outcome.p_value == pytest.approx((1 + np.sum(expected[1:] >= expected[0] - 1e-9)) / 20)


def test_statistic_is_the_cluster_robust_score_test_of_statsmodels() -> None:

    data = synthetic_columns(np.random.default_rng(2), cycles=25, memory=0.9)
    w = data.groups[2].shapes[0]
    e, free = OLS(data.noise, data.base).fit().resid, OLS(w[:, 0], data.base).fit().resid
    spread = S_crosssection((free * e)[:, None], data.cycle).item()
    observed, _ = CycleScores(data.noise, data.base, data.cycle, 25, np.ones((1, 25))).largest(data.groups[2])
    expected = marginal_evidence(np.array([(free @ e) ** 2 / spread]), 25, 1)
    assert observed == pytest.approx(expected[0], rel=1e-8)


def test_marginal_evidence_is_the_tail_of_the_beta_distribution_and_goes_on_beyond_what_floats_hold() -> None:

    share = np.array([0.01, 0.2, 0.5])
    assert marginal_evidence(share * 30, 30, 2) == pytest.approx(-beta.logsf(share, 1, 14), rel=1e-5)
    far = marginal_evidence(np.array([0.99, 0.999, 0.9999]) * 600, 600, 1)
    assert np.all(np.diff(far) > 100)


def test_balance_by_hand() -> None:
    draws = np.arange(20.0)
    observed, drawn = balanced(np.array([20.0, 40.0]), np.stack([draws, 2 * draws]))
    # Of 0, 1, ..., 20 one in twenty is above 19.
    assert observed.tolist() == pytest.approx([1.0, 2.0])
    np.testing.assert_allclose(drawn, np.stack([draws - 19, 2 * draws - 38]))


def test_a_candidate_of_many_shapes_does_not_hide_one_of_a_single_shape() -> None:
    rng = np.random.default_rng(0)
    data = synthetic_columns(rng, cycles=40, memory=0.5)
    many = Group(name="many", shapes=tuple(rng.standard_normal((len(data.noise), 1)) for _ in range(100)))
    found = []
    for seed in range(20):
        y = synthetic_columns(np.random.default_rng(seed), cycles=40, memory=0.5).noise + 0.13 * data.partial(1, 0)
        outcome = omnibus_test(y, data.base, [data.groups[1], many], data.cycle, rng, draws=499)
        alone = omnibus_test(y, data.base, [data.groups[1]], data.cycle, rng, draws=499)
        found.append((outcome.p_value <= 0.05, alone.p_value <= 0.025))
    # Two candidates share the error evenly: the one costs the other a factor of two, not of a hundred.
    assert abs(np.sum(found, axis=0) @ [1, -1]) <= 2


def test_step_down_by_hand() -> None:
    drawn = np.array([[1.0, 2.0, 3.0, 4.0], [4.0, 3.0, 2.0, 1.0]])
    # The largest is held against the maximum (4, 3, 3, 4), the other against its own draws only.
    assert step_down(np.array([3.5, 2.5]), drawn).tolist() == pytest.approx([3 / 5, 3 / 5])
    assert step_down(np.array([5.0, 3.5]), drawn).tolist() == pytest.approx([1 / 5, 2 / 5])


def test_cycles_stay_single_where_the_noise_forgets_and_join_where_it_does_not() -> None:
    cycle = np.repeat(np.arange(60), 100)
    assert independent_clusters(cycle, 19.0).tolist() == cycle.tolist()
    joined = independent_clusters(cycle, 50.0)  # 250 samples, three cycles
    assert joined.tolist() == (cycle // 3).tolist()
    assert len(np.unique(independent_clusters(cycle, 1000.0))) == 12
    assert len(np.unique(independent_clusters(cycle[:500], 1000.0))) == 5


def test_weights_have_mean_0_and_variance_1() -> None:
    assert WEBB.mean() == pytest.approx(0.0)
    assert np.mean(WEBB**2) == pytest.approx(1.0)
    few = bootstrap_weights(np.random.default_rng(0), 100, FEW_CYCLES - 1)
    many = bootstrap_weights(np.random.default_rng(0), 100, FEW_CYCLES)
    assert len(np.unique(few)) == 6
    assert np.unique(many).tolist() == [-1.0, 1.0]


def test_neighbours_that_remember_each_other_get_weights_that_do() -> None:
    weights = bootstrap_weights(np.random.default_rng(0), 4000, 20, remember=True)
    assert np.unique(weights).tolist() == [-1.0, 1.0]
    # Signs of normal variates with a correlation of a half: 2 / pi asin(1/2).
    assert np.mean(weights[:, 1:] * weights[:, :-1]) == pytest.approx(1 / 3, abs=0.02)
    assert np.mean(weights[:, 2:] * weights[:, :-2]) == pytest.approx(0.0, abs=0.02)


def test_clusters_of_three_memories_have_forgotten_their_neighbours() -> None:
    cluster = np.repeat(np.arange(12), 60)
    assert neighbours_remember(cluster, 20.5)
    assert not neighbours_remember(cluster, 19.5)


def test_the_missing_effect_has_the_smallest_adjusted_p() -> None:
    rng = np.random.default_rng(3)
    data = synthetic_columns(rng, cycles=40, memory=0.5)
    outcome = omnibus_test(data.noise + data.partial(5, 1), data.base, data.groups, data.cycle, rng)
    assert outcome.p_value == pytest.approx(1 / 1000)
    assert outcome.names[5] == "wave"
    assert outcome.adjusted_p[5] == outcome.adjusted_p.min() == outcome.p_value


def test_a_copy_of_the_base_carries_no_evidence() -> None:
    data = synthetic_columns(np.random.default_rng(4), cycles=20, memory=0.0)
    copy = Group(name="copy", shapes=(3.0 * data.base[:, 1:2],))
    outcome = omnibus_test(data.noise, data.base, [copy], data.cycle, np.random.default_rng(0), draws=19)
    assert outcome.p_value == 1.0


def test_too_few_cycles_are_refused_with_numbers() -> None:
    data = synthetic_columns(np.random.default_rng(4), cycles=6, memory=0.0)
    with pytest.raises(AnalysisError, match="6 cycles, expected at least 8 for 3 base and 2 candidate columns"):
        omnibus_test(data.noise, data.base, data.groups, data.cycle, np.random.default_rng(0))


def test_no_candidate_and_values_that_are_not_finite_are_refused() -> None:
    data = synthetic_columns(np.random.default_rng(4), cycles=20, memory=0.0)
    rng = np.random.default_rng(0)
    with pytest.raises(AnalysisError, match="no candidate"):
        omnibus_test(data.noise, data.base, [], data.cycle, rng)
    broken = Group(name="broken", shapes=(np.full((2000, 1), np.inf),))
    with pytest.raises(AnalysisError, match="response or base"):
        omnibus_test(data.noise * np.nan, data.base, data.groups, data.cycle, rng)
    with pytest.raises(AnalysisError, match=r"candidate broken: .* not finite"):
        omnibus_test(data.noise, data.base, [broken], data.cycle, rng)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.floats(1e-6, 1e6), st.floats(0, 6.28))
def test_neither_units_nor_the_order_of_anything_matters(seed: int, unit: float, angle: float) -> None:
    rng = np.random.default_rng(seed)
    data = synthetic_columns(rng, cycles=20, memory=0.5, per_cycle=40)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) * unit
    groups = [
        replace(g, shapes=tuple(w @ turn if w.shape[1] == 2 else w * unit for w in g.shapes)) for g in data.groups
    ]
    order, shuffled = rng.permutation(len(groups)), rng.permutation(len(data.noise))
    plain = omnibus_test(data.noise, data.base, data.groups, data.cycle, np.random.default_rng(9), draws=49)
    other = omnibus_test(
        (unit * data.noise)[shuffled],
        (data.base / unit)[shuffled],
        [replace(groups[i], shapes=tuple(w[shuffled] for w in groups[i].shapes)) for i in order],
        data.cycle[shuffled],
        np.random.default_rng(9),
        draws=49,
    )
    np.testing.assert_allclose(other.adjusted_p, plain.adjusted_p[order])
    assert other.p_value == plain.p_value


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_names_of_cycles_do_not_matter_to_the_statistic(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = synthetic_columns(rng, cycles=16, memory=0.5, per_cycle=40)
    renamed = rng.permutation(16)[data.cycle] * 7
    tables = []
    for cycle in (data.cycle, renamed):
        number = np.unique(cycle, return_inverse=True)[1]
        scores = CycleScores(data.noise, data.base, number, 16, np.ones((1, 16)))
        tables.append([scores.largest(group)[0] for group in data.groups])
    np.testing.assert_allclose(tables[1], tables[0], rtol=1e-6, atol=1e-9)


def test_candidates_with_more_samples_are_read_where_the_others_are() -> None:
    data = synthetic_columns(np.random.default_rng(3), cycles=20, memory=0.5, per_cycle=40)
    kept = data.cycle % 4 != 1
    some = [replace(g, shapes=tuple(w[kept] for w in g.shapes)) for g in data.groups]
    y, base, cycle = data.noise[kept], data.base[kept], data.cycle[kept]
    copied = omnibus_test(y, base, some, cycle, np.random.default_rng(4), draws=49)
    read = omnibus_test(y, base, data.groups, cycle, np.random.default_rng(4), draws=49, at=np.flatnonzero(kept))
    np.testing.assert_array_equal(read.adjusted_p, copied.adjusted_p)
    assert read.p_value == copied.p_value
