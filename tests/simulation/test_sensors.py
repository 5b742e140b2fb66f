from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulation.sensors import draw_noise
from friction_audit.simulation.settings import IDEAL_SENSORS, PANDA_SENSORS, Sensors

TICKS = 20_000


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def autocorrelation(noise: np.ndarray, lag: int) -> float:
    return float(np.corrcoef(noise[lag:], noise[:-lag])[0, 1])


def test_ideal_sensors_have_no_noise_but_draw_it() -> None:
    ideal, real, again = rng(1), rng(1), rng(1)
    noise = draw_noise(TICKS, 1000.0, IDEAL_SENSORS, ideal)
    draw_noise(TICKS, 1000.0, PANDA_SENSORS[0], real)
    assert_array_equal(noise, np.zeros((3, TICKS + 1)))
    assert ideal.random() == real.random() != again.random()


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_slow_part_keeps_the_variance_and_changes_the_colour(share: float) -> None:
    sensors = Sensors(torque_noise_nm=0.05, torque_correlation_s=0.002, slow_noise_share=share, slow_correlation_s=0.02)
    noise = draw_noise(20 * TICKS, 1000.0, sensors, rng(2))[0]
    assert_allclose(noise.std(), 0.05, rtol=0.04)
    for lag in (2, 10, 20):
        expected = (1 - share) * np.exp(-lag / 2) + share * np.exp(-lag / 20)
        assert_allclose(autocorrelation(noise, lag), expected, atol=0.03)


def test_slow_part_may_be_white_too() -> None:
    sensors = Sensors(torque_noise_nm=0.05, slow_noise_share=0.5, slow_correlation_s=0.0)
    assert abs(autocorrelation(draw_noise(TICKS, 1000.0, sensors, rng())[0], 1)) < 0.03


def test_share_above_one_is_refused() -> None:
    with pytest.raises(UsageError, match=r"slow_noise_share 1\.5: expected a share from 0 to 1"):
        replace(IDEAL_SENSORS, slow_noise_share=1.5)
