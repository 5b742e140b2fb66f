import numpy as np
import pytest
from statsmodels.regression.linear_model import WLS
from statsmodels.robust.robust_linear_model import RLM

from friction_audit.friction.robust_regression import huber_weights, newey_west_errors, solve_weighted
from friction_audit.friction.torque_regression import _slope
from friction_audit.joint_log import Float

TRUTH = np.array([0.2, 0.05, 0.1])
ROUNDS_WITH_THE_START = 10


def rows(samples: int = 2000) -> tuple[Float, Float]:
    """Heavy-tailed noise, correlated over five rows."""
    rng = np.random.default_rng(3)
    design = np.column_stack([np.sign(rng.normal(size=samples)), rng.normal(size=samples), np.ones(samples)])
    noise = np.convolve(rng.standard_t(3, size=samples + 4), np.ones(5) / 5, mode="valid")
    return design, design @ TRUTH + 0.1 * noise


def test_rows_on_a_line_find_it_and_keep_their_weight() -> None:
    design, _ = rows()
    target = design @ TRUTH
    weights = huber_weights(design, target)
    np.testing.assert_allclose(solve_weighted(design, target, weights)[0], TRUTH, rtol=1e-10)


def test_one_row_far_off_does_not_count() -> None:
    design, target = rows()
    target[7] += 1e6
    weights = huber_weights(design, target)
    assert weights[7] < 1e-5
    np.testing.assert_allclose(solve_weighted(design, target, weights)[0], TRUTH, atol=0.01)


def test_independent_rows_have_the_textbook_error() -> None:
    rng = np.random.default_rng(0)
    design, noise = np.ones((10_000, 1)), rng.normal(size=10_000)
    _, inverse = solve_weighted(design, noise, np.ones(10_000))
    assert newey_west_errors(noise[:, None], inverse, lags=3)[0] == pytest.approx(0.01, rel=0.05)


def test_weights_and_errors_are_those_of_statsmodels() -> None:
    design, target = rows()
    weights = huber_weights(design, target)
    np.testing.assert_allclose(weights, RLM(target, design).fit(maxiter=ROUNDS_WITH_THE_START).weights, rtol=1e-9)
    fit = WLS(target, design, weights=weights).fit(cov_type="HAC", cov_kwds={"maxlags": 6})
    solution, inverse = solve_weighted(design, target, weights)
    scores = design * (weights * (target - design @ solution))[:, None]
    np.testing.assert_allclose(solution, fit.params, rtol=1e-9)
    np.testing.assert_allclose(newey_west_errors(scores, inverse, lags=6), fit.bse, rtol=1e-9)


def test_the_slope_at_some_samples_is_numpys_gradient_there() -> None:
    t = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 100))
    signal, index = np.sin(t), np.array([0, 1, 50, 98, 99])
    np.testing.assert_allclose(_slope(signal, t, index), np.gradient(signal, t)[index], rtol=1e-9)
