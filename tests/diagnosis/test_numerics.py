"""Every step of the engine against a closed form, a library or a direct computation."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.stats import t as student

from friction_audit.diagnosis.dictionary import Dictionary
from friction_audit.diagnosis.fitted_model import FittedModel, held_out, measure_gap, wild_cluster_bootstrap
from friction_audit.diagnosis.gram import Gram, Training
from friction_audit.diagnosis.noise import NoiseModel
from friction_audit.diagnosis.nonlinear import intervals, refine
from friction_audit.diagnosis.problem import FOLDS, RegressionProblem, folds_of
from friction_audit.diagnosis.residual_checks import spectral_line
from friction_audit.diagnosis.selection import occam
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.registry import effect_of
from friction_audit.joint_log import Float
from tests.diagnosis.toy_effects import BUMP, SQUARE, WAVE, bump, rising
from tests.effects.joint_data_by_hand import moved_joint


@cache
def prepared(
    *effects: Effect, missing: Callable[[JointData], Float] = bump, duration_s: float = 60.0
) -> tuple[Gram, Dictionary]:
    """A joint of whose torque the nominal model misses a part, no nuisances, and columns of some effects."""
    problem = RegressionProblem.build(moved_joint(missing, noise_nm=0.02, duration_s=duration_s), None)
    baseline = problem.nominal.baseline(np.asarray(np.linalg.lstsq(problem.X.T, problem.y)[0], np.float64))
    noise = NoiseModel.fit(problem.age, [problem.y - problem.X.T @ np.linalg.lstsq(problem.X.T, problem.y)[0]],
                           np.zeros(len(problem.y)))  # fmt: skip
    dictionary = Dictionary.build(problem, effects, baseline)
    return Gram(problem, noise, (), dictionary.blocks), dictionary


def test_noise_is_an_autoregression_of_its_own_innovations() -> None:
    problem = RegressionProblem.build(moved_joint(duration_s=120.0), None)
    left = 0.05 * lfilter([1.0], [1.0, -0.6], np.random.default_rng(0).standard_normal(len(problem.y)))
    noise = NoiseModel.fit(problem.age, [left], np.zeros(len(left)))
    innovations = noise.whiten(left)[0]
    assert np.std(innovations) == pytest.approx(1.0, abs=0.05)
    assert abs(np.corrcoef(innovations[1:], innovations[:-1])[0, 1]) < 0.05
    for seed in range(20):  # a log at 30 Hz: few samples have a pair at the last lags, an order up to them explains all
        left = np.random.default_rng(seed).standard_normal(40)
        assert NoiseModel.fit(np.tile(np.arange(8), 5), [left], np.zeros(40)).scales[-1] < 2.0 / np.std(left)


def test_folds_hold_whole_cycles_spread_over_the_log() -> None:
    cycle = np.repeat(np.arange(23), 7)
    fold = folds_of(cycle)
    assert all(len(set(fold[cycle == c])) == 1 for c in range(23))
    assert np.array_equal(fold, folds_of(cycle))
    for first in range(0, 20, FOLDS):
        assert set(fold[(cycle >= first) & (cycle < first + FOLDS)]) == set(range(FOLDS))


@pytest.mark.parametrize(("gain", "numbers"), [(12.0, 1), (40.0, 3)])
def test_evidence_is_the_integral_over_a_prior_as_wide_as_suits_the_data(gain: float, numbers: int) -> None:
    """2 ln of: likelihood averaged over N(0, (v - 1) s^2) per coefficient, at the v that makes it largest."""
    each = gain / numbers  # squared estimate in units of its variance, the same of every coefficient

    def evidence(v: float) -> float:
        def integrand(b: float) -> float:
            prior = np.exp(-(b**2) / (2 * (v - 1))) / np.sqrt(2 * np.pi * (v - 1))
            return float(np.exp(-0.5 * (np.sqrt(each) - b) ** 2 + 0.5 * each) * prior)

        return 2.0 * numbers * float(np.log(quad(integrand, -30, 40, points=[np.sqrt(each)])[0]))

    largest = max(evidence(v) for v in np.geomspace(1.01, 20 * each, 400))
    assert float(occam(gain, float(numbers))) == pytest.approx(largest, abs=0.02)


def test_held_out_residuals_are_those_of_fits_without_the_fold() -> None:
    gram, _ = prepared(BUMP, WAVE, SQUARE)
    active = (gram.blocks[2],)
    white = np.vstack([gram.base, gram.of(active[0])]).T
    raw = np.vstack([gram.problem.X, active[0].columns]).T
    found, fold = held_out(gram, active), gram.problem.fold
    for k in range(FOLDS):
        others = fold[gram.order] != k
        coefficients = np.linalg.lstsq(white[others], gram.y[others])[0]
        assert found.residual[fold == k] == pytest.approx((gram.problem.y - raw @ coefficients)[fold == k], abs=1e-7)
    assert found.rms == pytest.approx(np.sqrt(np.mean(found.residual**2)))


def test_variance_inflation_is_that_of_regressing_each_torque_on_the_other_effects() -> None:
    gram, _ = prepared(BUMP, WAVE, SQUARE)
    active = [gram.blocks[2], next(b for b in gram.blocks if b.effect is WAVE)]

    def left(rows: Float, column: Float) -> float:
        return float(np.sum((column - np.linalg.lstsq(rows.T, column)[0] @ rows) ** 2))

    model, expected = FittedModel(Training(gram), active), []
    for k, block_torque in enumerate(model.torques):
        torque = gram.whiten(block_torque)[0]
        expected.append(left(gram.base, torque) / left(np.vstack([gram.base, gram.of(active[1 - k])]), torque))
    assert model.inflations == pytest.approx(expected, rel=1e-6)
    assert max(expected) > 1.001


def test_variable_projection_ends_where_nonlinear_least_squares_does() -> None:
    gram, dictionary = prepared(effect_of("stribeck"), missing=rising)
    training = Training(gram)
    start = gram.blocks[int(np.argmax(training.gain(())[0]))]
    names = list(dictionary.bounds(start))

    def residual(x: Float) -> Float:
        shape = {**start.shape, **dict(zip(names, np.exp(x), strict=True))}
        white = gram.whiten(dictionary.columns_at(start, shape, dictionary.baseline))
        columns = np.vstack([gram.base, white]).T
        return np.asarray(gram.y - columns @ np.linalg.lstsq(columns, gram.y)[0])

    low, high = np.log([dictionary.bounds(start)[name] for name in names]).T
    best = least_squares(residual, np.log([start.shape[name] for name in names]), bounds=(low, high))
    moved: Any = refine(dictionary, training, start, (), dictionary.baseline)
    left = float(np.sum(residual(np.log([moved.shape[name] for name in names])) ** 2))
    assert len(gram.y) * np.log(left / (2 * best.cost)) < 0.3  # 2 ln of the likelihood; the search stops at 0.2
    assert moved.shape["stribeck_speed_rad_s"] == pytest.approx(0.1, rel=0.1)


def test_intervals_are_leaving_out_one_cycle_at_a_time() -> None:
    gram, dictionary = prepared(SQUARE, duration_s=30.0)
    active = (gram.blocks[0],)
    found = intervals(FittedModel(Training(gram), active), dictionary)
    columns = np.vstack([gram.base, gram.of(active[0])]).T
    cycle = gram.problem.samples.cycle[gram.order]
    cycles = np.unique(cycle)
    without = np.stack([np.linalg.lstsq(columns[cycle != c], gram.y[cycle != c])[0] for c in cycles])
    m, full = len(cycles), np.linalg.lstsq(columns, gram.y)[0]
    se = np.sqrt((m - 1) / m * np.sum((without - full) ** 2, axis=0))
    sandwich = np.linalg.pinv(columns)
    parts = np.stack([np.sum(sandwich[:, cycle == c] ** 2, axis=1) for c in cycles])
    effective = parts.sum(axis=0) ** 2 / np.sum(parts**2, axis=0)
    assert np.all(effective <= m)
    half = [(one.high - one.low) / 2 for one in (*found.nominal.values(), *found.effects[0].values())]
    assert half == pytest.approx(student.ppf(0.975, effective - 1) * se, rel=1e-3)


def test_a_number_that_the_log_does_not_hold_is_not_identifiable_and_leaves_the_others_alone() -> None:
    gram, dictionary = prepared(effect_of("stribeck"))
    block = gram.blocks[0]
    found = intervals(FittedModel(Training(gram), (block,)), dictionary)
    plain = intervals(FittedModel(Training(gram), ()), dictionary)
    assert found.not_identifiable == ((*dictionary.bounds(block), "stribeck_excess_nm"),)
    for name, one in found.nominal.items():
        assert one.high - one.low == pytest.approx(plain.nominal[name].high - plain.nominal[name].low, rel=0.5)


@pytest.mark.thorough
def test_the_screening_test_keeps_its_level() -> None:
    """Of 60 joints with nothing missing at most 8 are below 0.05: more come less than once in a hundred times."""
    p_values = []
    for seed in range(60):
        problem = RegressionProblem.build(moved_joint(noise_nm=0.02, duration_s=20.0, seed=seed), None)
        left = problem.y - problem.X.T @ np.linalg.lstsq(problem.X.T, problem.y)[0]
        noise = NoiseModel.fit(problem.age, [left], np.zeros(len(left)))
        blocks = Dictionary.build(problem, (BUMP, WAVE, SQUARE), problem.nominal.baseline(np.zeros(3))).blocks
        p_values.append(wild_cluster_bootstrap(Gram(problem, noise, (), blocks), (), seed).p_value)
    assert np.count_nonzero(np.array(p_values) < 0.05) <= 8
    assert np.mean(p_values) == pytest.approx(0.5, abs=0.12)


def test_the_screening_test_sees_what_is_missing_and_its_place() -> None:
    found = wild_cluster_bootstrap(prepared(BUMP, WAVE, SQUARE)[0], (), 0)
    assert found.p_value == pytest.approx(1 / 400)
    assert found.curves["position"] < 0.01 < found.curves["time"]


def test_a_line_stands_out_at_its_frequency() -> None:
    t = np.arange(0.0, 60.0, 0.02)
    noise = np.random.default_rng(0).standard_normal(len(t))
    line: Any = spectral_line(noise + 2.0 * np.sin(2 * np.pi * 7.3 * t), t, 0.6, 20.0, np.ones(len(t)))
    assert line[0] == pytest.approx(7.3, abs=0.05)
    assert line[1] == pytest.approx(2.0 / 3.0, rel=0.3)
    assert spectral_line(noise, t, 0.6, 20.0, np.ones(len(t))) is None


CYCLE = np.repeat([4, 7, 9], 100)


@pytest.mark.parametrize(
    ("before", "after", "floor", "shrink", "over_floor"),
    [(0.5, 0.2, 0.1, 0.75, 2.0), (0.1, 0.1, 0.1 + 1e-9, np.nan, 1.0), (0.2, 0.3, 0.0, -0.5, np.inf)],
    ids=["closed by three quarters", "nothing to close", "a worse model, no noise"],
)
def test_gap_by_hand(before: float, after: float, floor: float, shrink: float, over_floor: float) -> None:
    sign = np.tile([1.0, -1.0], 150)
    gap = measure_gap(before * sign, after * sign, floor, CYCLE)
    assert (gap.before, gap.after, gap.cycles) == pytest.approx((before, after, 3))
    assert (gap.shrink, gap.over_floor) == pytest.approx((shrink, over_floor), nan_ok=True)


def test_standard_error_of_a_gap_is_that_of_leaving_out_each_cycle() -> None:
    rng = np.random.default_rng(0)
    before, after = rng.standard_normal(300), 0.5 * rng.standard_normal(300)
    kept = [np.not_equal(CYCLE, c) for c in (4, 7, 9)]
    without = np.array([measure_gap(before[k], after[k], 0.2, CYCLE[k]).shrink for k in kept])
    se = np.sqrt(2 / 3 * np.sum((without - without.mean()) ** 2))
    assert measure_gap(before, after, 0.2, CYCLE).shrink_se == pytest.approx(se)
    assert np.isnan(measure_gap(before, after, 0.2, np.zeros(300, dtype=np.int64)).shrink_se)
