import numpy as np
import pytest

from friction_audit.diagnosis.stroke_scatter import FEWEST_REVERSALS, find_stroke_scatter
from friction_audit.joint_log import Float

ROWS = 100
STROKES = 80
N = ROWS * STROKES
T = np.asarray(np.arange(N) * 0.01, np.float64)
FORWARDS = np.arange(N) // ROWS % 2 == 0
SIGN = np.where(FORWARDS, 1.0, -1.0)


def noise(memory: int, seed: int) -> Float:
    rng = np.random.default_rng(seed)
    white = rng.standard_normal(N + memory)
    smooth = np.convolve(white, np.ones(memory) / memory, mode="valid")[:N]
    return np.asarray(smooth / smooth.std())


def levels(seed: int, rows_each: int = 4 * ROWS) -> Float:
    """Friction of 0 or 1 for some time each."""
    drawn = np.random.default_rng(seed).integers(0, 2, N // rows_each + 1)
    return np.repeat(drawn - drawn.mean(), rows_each)[:N]


@pytest.mark.parametrize("memory", [1, 30, 300])
def test_noise_of_a_sensor_is_no_scatter_however_long_it_remembers(memory: int) -> None:
    assert all(find_stroke_scatter(noise(memory, seed), FORWARDS, T) is None for seed in range(50))


def test_noise_is_no_scatter_where_strokes_are_uneven_and_rests_part_them() -> None:
    rng = np.random.default_rng(0)
    forwards = np.repeat(np.arange(200) % 2 == 0, rng.integers(20, 200, 200))[:N]
    later = T + np.cumsum(np.append(False, np.diff(forwards))) * 0.3
    assert all(find_stroke_scatter(noise(100, seed), forwards, later) is None for seed in range(50))


@pytest.mark.parametrize("rows_each", [150, 4 * ROWS])
def test_a_brake_that_rubs_now_and_then_is_told_with_its_size(rows_each: int) -> None:
    friction = levels(2, rows_each)
    found = find_stroke_scatter(noise(1, 1) + SIGN * friction, FORWARDS, T)
    assert found is not None
    assert found.rms_nm == pytest.approx(friction.std(), rel=0.3)
    assert found.reversals == STROKES - 1
    assert "varies between strokes" in found.message


def test_a_scatter_that_is_a_third_of_the_noise_is_told() -> None:
    assert find_stroke_scatter(noise(1, 1) + 0.6 * SIGN * levels(2), FORWARDS, T) is not None


def test_a_torque_that_does_not_turn_with_the_direction_is_left_to_others() -> None:
    assert find_stroke_scatter(noise(1, 1) + levels(2), FORWARDS, T) is None


def test_a_few_strokes_tell_nothing() -> None:
    few = slice(0, ROWS * FEWEST_REVERSALS)
    assert find_stroke_scatter((SIGN * levels(2))[few], FORWARDS[few], T[few]) is None


def test_nothing_left_is_nothing_to_tell() -> None:
    assert find_stroke_scatter(np.zeros(N), FORWARDS, T) is None
