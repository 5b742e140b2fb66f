"""One filter for torque and motion, on real stamps."""

import numpy as np
import pytest

from friction_audit.discrepancy.prepare import low_pass_for


def test_a_slow_sine_passes_with_its_derivative() -> None:
    t = np.arange(0, 5, 1e-3)
    low_pass = low_pass_for(t)
    slow, slope = low_pass.with_slope(t, np.sin(4 * np.pi * t))
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    assert np.abs(slow - np.sin(4 * np.pi * low_pass.t))[inside].max() < 1e-3
    assert np.abs(slope - 4 * np.pi * np.cos(4 * np.pi * low_pass.t))[inside].max() < 2e-2


@pytest.mark.parametrize(("frequency", "gain"), [(5.0, 1.0), (25.0, 0.5), (60.0, 0.0)])
def test_corner(frequency: float, gain: float) -> None:
    t = np.arange(0, 5, 1e-3)
    low_pass = low_pass_for(t)
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    passed = low_pass.of(t, np.sin(2 * np.pi * frequency * t + 0.7))[inside]
    assert np.sqrt(2 * np.mean(passed**2)) == pytest.approx(gain, abs=0.01)


@pytest.mark.parametrize("rate", [50.0, 100.0, 300.0, 1000.0])
def test_grid_is_not_faster_than_the_log(rate: float) -> None:
    low_pass = low_pass_for(np.arange(0, 5, 1 / rate))
    assert 1 / (low_pass.t[1] - low_pass.t[0]) == pytest.approx(min(rate, 100.0))
    assert low_pass.of(np.arange(0, 5, 1 / rate), np.ones(round(5 * rate))) == pytest.approx(1.0)
