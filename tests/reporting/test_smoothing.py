import numpy as np
import pytest

from friction_audit.reporting.figures.style import CUTOFF_HZ, cutoff_hz, smooth


def test_a_slow_signal_passes_without_delay_and_a_fast_one_is_gone() -> None:
    t = np.arange(0, 10, 0.001)
    slow, fast = np.sin(2 * np.pi * 0.5 * t), np.sin(2 * np.pi * 100 * t)
    inside = slice(1000, -1000)
    assert smooth(t, slow + fast)[inside] == pytest.approx(slow[inside], abs=2e-3)


def test_a_slow_log_lowers_the_corner() -> None:
    assert cutoff_hz(np.arange(0, 10, 0.001)) == CUTOFF_HZ
    assert cutoff_hz(np.arange(0, 10, 1 / 30)) == pytest.approx(6.0)


def test_a_handful_of_samples_is_left_alone() -> None:
    t = np.arange(5.0)
    assert smooth(t, t) is t
