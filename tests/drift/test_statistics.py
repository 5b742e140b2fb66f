"""The parts of the drift tests, each against numbers known by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from friction_audit.drift.change_test import estimate_autocorrelation, make_directions, studentise
from friction_audit.drift.session import Series, make_series
from friction_audit.joint_log import Float
from tests.drift.made_sessions import make_sessions, noisy


def series_of(level: np.ndarray, error: float = 0.003) -> Series:
    sessions = make_sessions(level, error=error)
    return replace(make_series(sessions, range(len(level)), 1, "coulomb_nm", by_start=True), temperature=None)


def test_statistics_of_a_step_and_of_a_ramp_are_those_of_the_usual_tests() -> None:
    level = noisy(12, 5)
    directions = make_directions(series_of(level, error=1e-9))
    assert np.ptp(directions.weight) < 1e-6 * directions.weight[0]  # errors are far below the scatter
    t, y = studentise(directions.residual[None, :], directions)[0], np.log(level)
    step = t[directions.split == 5][0]
    assert step == pytest.approx(stats.ttest_ind(y[5:], y[:5]).statistic, rel=1e-4)
    line = stats.linregress(np.arange(12), y)
    assert t[directions.split == 0] == pytest.approx(line.slope / line.stderr, rel=1e-4)


def wandering(rng: np.random.Generator, count: int, length: int, correlation: float) -> Float:
    """Return series, each session of which remembers the one before it, shape (count, length)."""
    noise = rng.standard_normal((count, length))
    for i in range(1, length):
        noise[:, i] = correlation * noise[:, i - 1] + np.sqrt(1 - correlation**2) * noise[:, i]
    return noise


@pytest.mark.parametrize("correlation", [0.0, 0.4, 0.7])
def test_autocorrelation_of_many_series(correlation: float) -> None:
    """The estimate is near the truth, steps and ramps notwithstanding; what it does is not underrated."""
    rng = np.random.default_rng(1)
    drifts = [0.0, 0.3 * np.arange(60), 8.0 * (np.arange(60) >= 40)]
    noise = wandering(rng, 14, 60, correlation)
    family = [make_directions(series_of(0.3 + 0.003 * (one + drifts[k % 3]), 1e-5)) for k, one in enumerate(noise)]
    found = estimate_autocorrelation(family, rng)
    assert found.first == pytest.approx(correlation, abs=0.15)
    largest = [
        np.quantile(np.max(np.abs(studentise(wandering(rng, 2000, 60, c), family[0])), axis=1), 0.99)
        for c in (0.0, correlation)
    ]
    assert 0.95 < found.growth * largest[0] / largest[1] < 1.6
