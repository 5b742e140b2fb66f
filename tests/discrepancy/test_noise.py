"""Integral time, whitening and the floor against noise whose memory is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.discrepancy.noise import (
    Autoregression,
    effective_samples,
    fit_autoregression,
    integral_time,
    noise_floor,
    runs_of,
    whiten,
)
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
    known = (1 + memory) / (1 - memory)
    assert integral_time(e, run) == pytest.approx(known, rel=0.15)
    assert effective_samples(e, run) == pytest.approx(60_000 / known, rel=0.15)


def test_autoregression_finds_the_memory_and_whitens_it() -> None:
    e = ar1(0.8, 20_000, 2)
    run = np.repeat(np.arange(40), 500)
    noise = fit_autoregression(e, run, white_floor=0.0)
    assert noise.coefficients[0] == pytest.approx(0.8, abs=0.03)
    assert noise.sigma == pytest.approx(1.0, abs=0.02)
    white, whole = whiten(e, run, noise)
    assert abs(np.corrcoef(white[whole][1:], white[whole][:-1])[0, 1]) < 0.03


def test_whitening_does_not_cross_a_border() -> None:
    noise = Autoregression(coefficients=np.array([0.5]), sigma=1.0)
    white, whole = whiten(np.array([2.0, 2.0, 8.0, 8.0]), np.array([0, 0, 1, 1]), noise)
    assert whole.tolist() == [False, True, False, True]
    assert white[whole].tolist() == [1.0, 4.0]


def test_floor_is_the_noise_and_not_the_curve_the_model_lacks() -> None:
    rng = np.random.default_rng(3)
    cycle = np.repeat(np.arange(40), 200)
    dq = np.tile(np.sin(np.linspace(0, 2 * np.pi, 200)), 40) * np.repeat(rng.uniform(0.5, 1.5, 40), 200)
    torque = np.sign(dq) + dq + 0.5 * np.sin(3 * dq) + 0.1 * rng.standard_normal(len(dq))
    floor = noise_floor(torque, dq[:, None], np.column_stack([np.sign(dq), dq]), cycle)
    assert floor == pytest.approx(0.1, rel=0.1)
