import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from friction_audit.preprocessing.velocity import filter_velocity


def test_a_constant_stays_what_it_is() -> None:
    np.testing.assert_allclose(filter_velocity(np.full(100, 0.3), rate_hz=1000, cutoff_hz=20), 0.3, rtol=1e-12)


def test_a_slow_sine_passes_without_delay_and_a_fast_one_is_gone() -> None:
    t = np.arange(0, 4, 0.001)
    slow, fast = np.sin(2 * np.pi * t), np.sin(2 * np.pi * 200 * t)
    filtered = filter_velocity(slow + fast, rate_hz=1000, cutoff_hz=20)
    np.testing.assert_allclose(filtered[200:-200], slow[200:-200], atol=1e-3)


@pytest.mark.parametrize(("rate_hz", "samples"), [(40.0, 100), (1000.0, 15)])
def test_what_cannot_be_filtered_is_left_alone(rate_hz: float, samples: int) -> None:
    dq = np.random.default_rng(0).normal(size=samples)
    assert filter_velocity(dq, rate_hz=rate_hz, cutoff_hz=20) is dq


@given(st.integers(0, 1000), st.integers(16, 3000), st.floats(51, 10_000))
def test_the_filter_is_that_of_scipy(seed: int, samples: int, rate_hz: float) -> None:
    dq = np.random.default_rng(seed).normal(size=samples).cumsum()
    expected = sosfiltfilt(butter(2, 20.0, fs=rate_hz, output="sos"), dq)
    filtered = filter_velocity(dq, rate_hz=rate_hz, cutoff_hz=20.0)
    np.testing.assert_allclose(filtered, expected, atol=1e-9 * np.abs(dq).max())
