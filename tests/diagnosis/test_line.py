"""A line in time or in the path travelled is found where it is; noise of any colour has none."""

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.line import find_line
from friction_audit.joint_log import Float

T = np.asarray(np.arange(6000) * 0.01, np.float64)
REST = (T % 7.0) < 1.5
MOVED = T[~REST]
GOING = (MOVED % 1.1) < 0.7
"""Stop and go."""
SPEED = np.abs(np.sin(T))[~REST]
PATH = np.cumsum(np.abs(np.sin(T)) * 0.01)[~REST]


def noise(memory: float, seed: int) -> Float:
    drawn = np.asarray(lfilter([1.0], [1.0, -memory], np.random.default_rng(seed).standard_normal(len(T))))[~REST]
    return drawn / float(drawn.std())


@pytest.mark.parametrize("memory", [0.0, 0.9, 0.98, 0.998])
def test_noise_of_any_colour_has_no_line(memory: float) -> None:
    along_path = 0
    for seed in range(40):
        assert find_line(noise(memory, seed), MOVED, 0.6, 25.0, 0.2) is None
        assert find_line(noise(memory, seed)[GOING], MOVED[GOING], 0.6, 25.0, 0.2) is None
        along_path += find_line(noise(memory, seed), PATH, 0.05, 10.0, 0.2, SPEED) is not None
    # Noise that remembers longer than strokes last follows the path of strokes that are all alike.
    assert along_path <= (2 if memory > 0.9 else 0)


@pytest.mark.parametrize("memory", [0.0, 0.9])
@pytest.mark.parametrize("frequency", [1.3, 5.0, 12.0])
def test_a_hum_of_a_third_of_the_noise_is_found_with_its_size(frequency: float, memory: float) -> None:
    hum = 0.33 * np.sqrt(2.0) * np.sin(2.0 * np.pi * frequency * MOVED + 0.4)
    found = find_line(noise(memory, 1) + hum, MOVED, 0.6, 25.0, 0.2)
    assert found is not None
    assert found.frequency == pytest.approx(frequency, abs=0.02)
    assert found.rms_nm == pytest.approx(0.33, rel=0.3)


def test_what_comes_round_with_the_path_is_a_line_there_and_not_in_time() -> None:
    turning = np.sin(2.0 * np.pi * 0.4 * PATH)
    found = find_line(noise(0.0, 2) + turning, PATH, 0.05, 10.0, 0.2, SPEED)
    assert found is not None
    assert found.frequency == pytest.approx(0.4, abs=0.02)
    assert find_line(noise(0.0, 2) + turning, MOVED, 0.6, 25.0, 0.2) is None


def test_a_small_line_is_not_worth_a_word() -> None:
    hum = 0.1 * np.sin(2.0 * np.pi * 5.0 * MOVED)
    assert find_line(0.2 * noise(0.0, 3) + hum, MOVED, 0.6, 25.0, 0.2) is None


def test_what_does_not_come_round_five_times_is_no_line() -> None:
    hum = np.sin(2.0 * np.pi * 0.05 * MOVED)
    assert find_line(hum, MOVED, 0.0, 0.06, 0.0) is None
    assert find_line(np.zeros(0), np.zeros(0), 0.6, 25.0, 0.0) is None


def test_five_rounds_of_noise_are_no_line() -> None:
    """What is slower is taken away: what is left next to it would stand out of what is not left."""
    found = [find_line(noise(0.9, seed), PATH, 0.0, 3.0, 0.2, SPEED) for seed in range(50, 100)]
    assert found == [None] * 50
