from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulation.motion.periodic import Commanded, frequencies_hz, intend_joints

DT = 1e-3


def test_frequencies_by_hand() -> None:
    """The primes 2, 19, 47, 79 and 109 for the first of seven joints; 3 first for the second."""
    expected = np.sqrt(np.array([2, 19, 47, 79, 109]) / 2)
    frequencies = frequencies_hz(Commanded(lowest_hz=1.0), 7)
    assert_allclose(frequencies[0], expected)
    assert_allclose(frequencies[1, 0], np.sqrt(1.5))
    assert_array_equal(frequencies_hz(Commanded(lowest_hz=1.0), 1), frequencies[:1])
    assert len(np.unique(frequencies)) == 35
    assert len(np.unique(frequencies_hz(Commanded(sines=1), 20))) == 20


def test_spectrum_has_the_sines_and_nothing_else() -> None:
    ticks = 400_000
    velocity = Commanded(sines=3).intend(ticks, DT, np.random.default_rng(1)).velocity
    spectrum = np.abs(np.fft.rfft(velocity * np.hanning(ticks + 1)))
    found = np.flatnonzero((spectrum[1:-1] > spectrum[:-2]) & (spectrum[1:-1] > spectrum[2:])) + 1
    found = found[spectrum[found] > 0.1 * spectrum.max()]
    assert_allclose(found / (ticks * DT), frequencies_hz(Commanded(sines=3), 1)[0], atol=0.002)


def test_joints_start_and_end_at_rest_and_are_independent() -> None:
    joints = intend_joints(Commanded(), 7, 60_000, DT, np.random.default_rng(3))
    assert joints.position.shape == joints.velocity.shape == (60_001, 7)
    for column in (joints.position, joints.velocity):
        assert_array_equal(column[[0, -1]], 0.0)
    slopes = (joints.position[2:] - joints.position[:-2]) / (2 * DT)
    assert_allclose(slopes, joints.velocity[1:-1], atol=1e-4)
    assert np.linalg.cond(np.corrcoef(joints.velocity.T)) < 5.0


@given(
    seed=st.integers(0, 2**32 - 1),
    sines=st.integers(1, 9),
    low=st.floats(0.01, 2.0),
    high=st.floats(0.01, 2.0),
    speed=st.floats(0.01, 3.0),
    ticks=st.integers(2, 8000),
)
@settings(max_examples=50, deadline=None)
def test_meets_one_of_its_bounds_and_keeps_all(
    seed: int, sines: int, low: float, high: float, speed: float, ticks: int
) -> None:
    commanded = Commanded(sines=sines, range_rad=(-low, high), peak_speed_rad_s=speed)
    intention = commanded.intend(ticks, DT, np.random.default_rng(seed))
    shares = (
        -intention.position.min() / low,
        intention.position.max() / high,
        np.abs(intention.velocity).max() / speed,
    )
    assert_allclose(max(shares), 1.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"lowest_hz": 0.0}, "lowest_hz 0: expected a number above zero"),
        ({"sines": 0}, "sines 0"),
        ({"ease_s": 0.0}, "ease_s 0"),
        ({"peak_speed_rad_s": -1.0}, "peak_speed_rad_s -1"),
        ({"range_rad": (1.0, -1.0)}, "range_rad 1, -1: expected the smaller number first"),
        ({"range_rad": (0.0, 1.0)}, "range_rad 0, 1: expected a range around the start at 0"),
    ],
)
def test_impossible_multisines_are_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError, match=f"^commanded: {words}"):
        Commanded(**wrong)
