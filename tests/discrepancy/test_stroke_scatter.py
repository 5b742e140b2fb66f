import numpy as np
import pytest

from friction_audit.discrepancy.stroke_scatter import FEWEST_PAIRS, find_stroke_scatter
from friction_audit.joint_log import Float

ROWS = 100
STROKES = 80
FORWARDS = np.arange(ROWS * STROKES) // ROWS % 2 == 0
ONE_RUN = np.zeros(ROWS * STROKES, dtype=np.int64)


def noise(memory: int, seed: int) -> Float:
    rng = np.random.default_rng(seed)
    white = rng.standard_normal(len(FORWARDS) + memory)
    smooth = np.convolve(white, np.ones(memory) / memory, mode="valid")[: len(FORWARDS)]
    return np.asarray(smooth / smooth.std())


def levels(seed: int, strokes_each: int = 4) -> Float:
    """Friction of 0 or 1 for some strokes each."""
    drawn = np.random.default_rng(seed).integers(0, 2, STROKES // strokes_each)
    return np.repeat(drawn - drawn.mean(), ROWS * strokes_each)


@pytest.mark.parametrize("memory", [1, 30, 300])
def test_noise_of_a_sensor_is_no_scatter_however_long_it_remembers(memory: int) -> None:
    assert all(find_stroke_scatter(noise(memory, seed), FORWARDS, ONE_RUN) is None for seed in range(50))


def test_a_brake_that_rubs_now_and_then_is_told_with_its_size() -> None:
    sign = np.where(FORWARDS, 1.0, -1.0)
    found = find_stroke_scatter(noise(1, 1) + sign * levels(2), FORWARDS, ONE_RUN)
    assert found is not None
    assert found.rms_nm == pytest.approx(0.5, rel=0.3)
    assert found.strokes == STROKES - 1
    assert "from stroke to stroke" in found.message


def test_a_torque_that_does_not_turn_with_the_direction_is_left_to_others() -> None:
    assert find_stroke_scatter(noise(1, 1) + levels(2), FORWARDS, ONE_RUN) is None


def test_a_scatter_that_is_small_beside_the_noise_is_not_told() -> None:
    sign = np.where(FORWARDS, 1.0, -1.0)
    assert find_stroke_scatter(noise(1, 1) + 0.3 * sign * levels(2), FORWARDS, ONE_RUN) is None


def test_a_few_strokes_tell_nothing() -> None:
    few = slice(0, ROWS * FEWEST_PAIRS)
    sign = np.where(FORWARDS, 1.0, -1.0)
    assert find_stroke_scatter((sign * levels(2))[few], FORWARDS[few], ONE_RUN[few]) is None


def test_rests_between_strokes_part_them_no_further_and_scraps_are_no_strokes() -> None:
    sign = np.where(FORWARDS, 1.0, -1.0)
    apart = np.arange(len(FORWARDS)) // ROWS
    assert find_stroke_scatter(sign * levels(2), FORWARDS, apart) is not None
    assert find_stroke_scatter(sign * levels(2), FORWARDS, np.arange(len(FORWARDS))) is None


def test_nothing_left_is_nothing_to_tell() -> None:
    assert find_stroke_scatter(np.zeros(len(FORWARDS)), FORWARDS, ONE_RUN) is None
