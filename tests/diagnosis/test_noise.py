"""Integral time against noise whose memory is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.noise import autocovariance, integral_time, runs_of
from friction_audit.joint_log import Float


def ar1(memory: float, n: int, seed: int) -> Float:
    white = np.random.default_rng(seed).standard_normal(n + 1000)
    return np.asarray(lfilter([1.0], [1.0, -memory], white)[1000:])


def test_runs_end_at_cycles_and_at_samples_left_out() -> None:
    used = np.array([1, 1, 0, 1, 1, 1], bool)
    assert runs_of(used, np.array([0, 0, 0, 0, 1, 1])).tolist() == [0, 0, -1, 1, 2, 2]


@pytest.mark.parametrize("memory", [pytest.param(0.0, marks=pytest.mark.thorough), 0.5, 0.9])
def test_integral_time_of_a_known_process(memory: float) -> None:
    e = ar1(memory, 60_000, 1)
    run = np.repeat(np.arange(60), 1000)
    assert integral_time(e, run) == pytest.approx((1 + memory) / (1 - memory), rel=0.15)


@pytest.mark.parametrize("smooth", [1, 7, 40])
def test_the_sum_ends_with_the_first_pair_of_lags_below_zero(smooth: int) -> None:
    rng = np.random.default_rng(smooth)
    e = np.convolve(rng.standard_normal(3000), np.ones(smooth), mode="same")
    run = np.repeat([0, -1, 1, 2], [900, 100, 1200, 800])
    sums, pairs = autocovariance(e, run, 400)
    rho = sums / pairs * pairs[0] / sums[0]
    both = rho[:400:2] + rho[1:400:2]
    assert integral_time(e, run) == pytest.approx(max(2.0 * both[: np.argmax(both <= 0.0)].sum() - 1.0, 1.0))
