from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.motion import MOTIONS, MotionSettings, Sinusoid, intend

DT = 1e-3
TICKS = 20_000

every_motion = pytest.mark.parametrize("motion", MOTIONS)


@every_motion
def test_starts_and_ends_at_rest(motion: type[MotionSettings]) -> None:
    intention = intend(motion(), TICKS, DT, np.random.default_rng(1))
    assert intention.position.shape == intention.velocity.shape == (TICKS + 1,)
    assert intention.position[0] == intention.velocity[0] == intention.velocity[-1] == 0.0
    assert np.ptp(intention.position) > 0.1


@every_motion
def test_velocity_is_the_derivative_of_the_position(motion: type[MotionSettings]) -> None:
    """The central difference of a tenth of the step is a hundred times closer, but for the jumps of acceleration."""
    error = []
    for dt in (DT, DT / 10):
        ticks = round(TICKS * DT / dt)
        intention = intend(motion(), ticks, dt, np.random.default_rng(2))
        slope = (intention.position[2:] - intention.position[:-2]) / (2 * dt)
        error.append(np.median(np.abs(slope - intention.velocity[1:-1])[intention.velocity[1:-1] != 0.0]))
        assert_allclose(slope, intention.velocity[1:-1], atol=dt)
    coarse, fine = error
    assert fine <= 0.011 * coarse + 1e-11


@every_motion
def test_same_seed_gives_the_same_motion(motion: type[MotionSettings]) -> None:
    one, same = (intend(motion(), TICKS, DT, np.random.default_rng(3)) for _ in range(2))
    assert_array_equal(one.position, same.position)
    assert_array_equal(one.velocity, same.velocity)


@every_motion
def test_seeds_give_different_motions(motion: type[MotionSettings]) -> None:
    settings: MotionSettings = Sinusoid(spread=0.2) if motion is Sinusoid else motion()
    positions = [intend(settings, 3 * TICKS, DT, np.random.default_rng(seed)).position for seed in range(4)]
    assert all(np.abs(one - other).max() > 0.01 for one, other in pairwise(positions))


@every_motion
def test_recording_too_short_for_any_motion_is_allowed(motion: type[MotionSettings]) -> None:
    intention = intend(motion(), 2, DT, np.random.default_rng(4))
    assert np.abs(intention.position).max() <= 0.8
    assert_allclose(intention.velocity[[0, -1]], 0.0, atol=0)
