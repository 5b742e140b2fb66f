from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.simulation.motion import MotionSettings

DT = 1e-3
TICKS = 20_000

every_motion = pytest.mark.parametrize("motion", get_args(MotionSettings))


@every_motion
def test_starts_and_ends_at_rest(motion: type[MotionSettings]) -> None:
    intention = motion().intend(TICKS, DT, np.random.default_rng(1))
    assert intention.position.shape == intention.velocity.shape == (TICKS + 1,)
    assert intention.position[0] == intention.velocity[0] == intention.velocity[-1] == 0.0
    assert np.ptp(intention.position) > 0.1


@every_motion
def test_velocity_is_the_derivative_of_the_position(motion: type[MotionSettings]) -> None:
    """The central difference of a tenth of the step is a hundred times closer, but for the jumps of acceleration."""
    error = []
    for dt in (DT, DT / 10):
        ticks = round(TICKS * DT / dt)
        intention = motion().intend(ticks, dt, np.random.default_rng(2))
        slope = (intention.position[2:] - intention.position[:-2]) / (2 * dt)
        error.append(np.median(np.abs(slope - intention.velocity[1:-1])[intention.velocity[1:-1] != 0.0]))
        assert_allclose(slope, intention.velocity[1:-1], atol=dt)
    coarse, fine = error
    assert fine <= 0.011 * coarse + 1e-11


@every_motion
def test_recording_too_short_for_any_motion_is_allowed(motion: type[MotionSettings]) -> None:
    intention = motion().intend(2, DT, np.random.default_rng(4))
    assert np.abs(intention.position).max() <= 0.8
    assert_allclose(intention.velocity[[0, -1]], 0.0, atol=0)
