import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.effects.torque_drift import RANDOM_WALK, THERMAL, TorqueDrift, reading_nm

T = np.linspace(5.0, 65.0, 601)
FORMS = range(len(TorqueDrift.forms))


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_ramp() -> None:
    drift = reading_nm(TorqueDrift(torque_nm=-0.3), T, rng())
    assert_allclose(drift[[0, 200, 600]], [0.0, -0.1, -0.3])


def test_thermal_settling() -> None:
    drift = reading_nm(TorqueDrift(torque_nm=0.3, settling_s=20.0, form=THERMAL), T, rng())
    full = 0.3 / (1 - math.exp(-3))
    assert_allclose(drift[[0, 200, 600]], [0.0, full * (1 - math.exp(-1)), 0.3])


def test_random_walk_ends_with_its_standard_deviation() -> None:
    group = TorqueDrift(torque_nm=0.3, form=RANDOM_WALK)
    walks = np.array([reading_nm(group, T, rng(seed)) for seed in range(2000)])
    assert_array_equal(walks[:, 0], 0.0)
    assert_allclose(walks[:, -1].std(), 0.3, rtol=0.06)
    assert_allclose(walks[:, 150].std(), 0.15, rtol=0.06)


@pytest.mark.parametrize("form", FORMS)
def test_steady_sensor_adds_nothing_and_draws_nothing(form: int) -> None:
    used, fresh = rng(1), rng(1)
    assert_array_equal(reading_nm(TorqueDrift(form=form), T, used), 0.0)
    assert used.random() == fresh.random()
