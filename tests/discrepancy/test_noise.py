"""Integral time against noise whose memory is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.discrepancy.noise import integral_time, runs_of
from friction_audit.joint_log import Float


def ar1(memory: float, n: int, seed: int) -> Float:
    white = np.random.default_rng(seed).standard_normal(n + 1000)
    return np.asarray(lfilter([1.0], [1.0, -memory], white)[1000:])


def test_runs_end_at_cycles_and_at_samples_left_out() -> None:
    used = np.array([1, 1, 0, 1, 1, 1], bool)
    assert runs_of(used, np.array([0, 0, 0, 0, 1, 1])).tolist() == [0, 0, -1, 1, 2, 2]


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_integral_time_of_a_known_process(memory: float) -> None:
    e = ar1(memory, 60_000, 1)
    run = np.repeat(np.arange(60), 1000)
    assert integral_time(e, run) == pytest.approx((1 + memory) / (1 - memory), rel=0.15)
