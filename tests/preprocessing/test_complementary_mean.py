"""The mean of two velocities: the derivative of a coarse position and a noisy tachometer."""

import numpy as np
import pytest

from friction_audit.joint_log import Float
from friction_audit.preprocessing.velocity import complementary_mean, crossover_of

STEP_S = 1.0 / 400.0
T: Float = np.arange(40000, dtype=np.float64) * STEP_S
TRUE: Float = np.sin(2 * np.pi * 0.5 * T)
ALL = np.ones(len(T), bool)


def readings(q_noise: float, dq_noise: float) -> tuple[Float, Float]:
    """Noise of the position's derivative and of a tachometer, up to 80 Hz each."""
    rng = np.random.default_rng(0)
    hertz = np.fft.rfftfreq(len(T), STEP_S)
    white = [np.fft.rfft(rng.standard_normal(len(T))) * (hertz < 80.0) for _ in range(2)]
    slope = np.fft.irfft(2j * np.pi * hertz * white[0])
    return TRUE + q_noise * slope, TRUE + dq_noise * np.fft.irfft(white[1])


def below(signal: Float, hertz: float) -> float:
    """Root mean square of what is below a frequency."""
    inside = np.fft.rfftfreq(len(T), STEP_S) < hertz
    return float(np.std(np.fft.irfft(np.fft.rfft(signal) * inside)))


def test_the_crossover_is_where_both_are_equally_noisy() -> None:
    assert crossover_of(*readings(1e-5, 2 * np.pi * 20.0 * 1e-5), STEP_S) == pytest.approx(20.0, rel=0.1)


def test_below_the_frequencies_of_motions_there_is_none() -> None:
    assert crossover_of(*readings(1e-3, 2 * np.pi * 1e-3), STEP_S) == 0.0
    assert crossover_of(np.zeros(50), np.ones(50), STEP_S) == 0.0


def test_the_mean_is_quieter_than_either_at_all_frequencies() -> None:
    slope, logged = readings(1e-5, 2 * np.pi * 20.0 * 1e-5)
    both = complementary_mean(slope, logged, ALL, STEP_S, 20.0) - TRUE
    for hertz in (5.0, 20.0, 80.0):
        assert below(both, hertz) < min(below(slope - TRUE, hertz), below(logged - TRUE, hertz))
    assert below(both, 5.0) < 0.3 * below(logged - TRUE, 5.0)


def test_where_the_position_cannot_be_trusted_it_is_the_logged_one() -> None:
    slope, logged = readings(1e-5, 1e-3)
    hole = (T > 40.0) & (T < 45.0)
    wild = np.where(hole, 1e3, slope)
    both = complementary_mean(wild, logged, ~hole, STEP_S, 20.0)
    inside = (T > 41.0) & (T < 44.0)
    assert both[inside] == pytest.approx(logged[inside])
    assert np.abs(both - TRUE).max() < 0.01
