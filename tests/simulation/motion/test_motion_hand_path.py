from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from friction_audit.errors import UsageError
from friction_audit.simulation.motion.hand_path import HandPath, plan_hand

DT = 1e-3
TICKS = 20_000


def _rng(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("rotation_rad", [1e-5, 0.6, 3.0])
def test_velocities_are_the_derivatives(rotation_rad: float) -> None:
    hand = plan_hand(HandPath(rotation_rad=rotation_rad), TICKS, DT, _rng(1))
    slopes = (hand.position[2:] - hand.position[:-2]) / (2 * DT)
    assert_allclose(slopes, hand.velocity[1:-1], atol=1e-5)
    orientation = Rotation.from_rotvec(hand.rotation)
    turned = (orientation[2:] * orientation[:-2].inv()).as_rotvec() / (2 * DT)
    assert_allclose(turned, hand.angular[1:-1], atol=2e-5 * rotation_rad)


def test_starts_and_ends_at_rest() -> None:
    hand = plan_hand(HandPath(), TICKS, DT, _rng(2))
    for signal in (hand.position, hand.rotation, hand.velocity, hand.angular):
        assert signal.shape == (TICKS + 1, 3)
        assert_array_equal(signal[0], 0.0)
    assert_array_equal(hand.velocity[-1], 0.0)
    assert_array_equal(plan_hand(HandPath(), 1000, DT, _rng(2)).position, 0.0)


def test_seed_decides() -> None:
    one, same, other = (plan_hand(HandPath(), TICKS, DT, _rng(seed)) for seed in (3, 3, 4))
    assert_array_equal(one.position, same.position)
    assert_array_equal(one.angular, same.angular)
    assert np.abs(one.position - other.position).max() > 0.01


def test_every_direction_is_moved_and_turned() -> None:
    hand = plan_hand(HandPath(), 60_000, DT, _rng(5))
    assert (np.ptp(hand.position, axis=0) > 0.12).all()
    assert (np.ptp(hand.rotation, axis=0) > 0.5).all()
    speed = np.linalg.norm(hand.velocity, axis=1)
    assert 0.5 < (speed > 0).mean() < 0.9


@given(
    seed=st.integers(0, 2**32 - 1),
    reach=st.floats(0.01, 0.5),
    sideways=st.floats(0.5, 3.0),
    rotation=st.floats(0.0, 3.0),
    fastest=st.floats(0.1, 2.0),
    turning=st.floats(0.1, 3.0),
)
@settings(max_examples=30, deadline=None)
def test_bounds_hold(seed: int, reach: float, sideways: float, rotation: float, fastest: float, turning: float) -> None:
    path = HandPath(
        reach_m=reach, sideways=sideways, rotation_rad=rotation, speed_m_s=(0.1, fastest), turning_rad_s=turning
    )
    hand = plan_hand(path, 5000, 4e-3, _rng(seed))
    for signal, bound in (
        (hand.position / (1.0, sideways, 1.0), reach),
        (hand.rotation, rotation),
        (hand.velocity, fastest),
        (hand.angular, turning),
    ):
        assert np.linalg.norm(signal, axis=1).max() <= bound * (1 + 1e-9)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"reach_m": 0.0}, "reach_m 0: expected 0.001 or more"),
        ({"rotation_rad": 3.2}, "rotation_rad 3.2: expected less than half a turn"),
        ({"rotation_rad": -0.1}, "rotation_rad -0.1: expected zero or more"),
        ({"stroke_s": (0.0, 1.0)}, "shortest_stroke_s 0"),
        ({"speed_m_s": (0.5, 0.2)}, "speed_m_s 0.5, 0.2: expected the smaller number first"),
        ({"turning_rad_s": 0.0}, "turning_rad_s 0"),
        ({"pause_s": (-0.1, 0.2)}, "shortest_pause_s -0.1"),
    ],
)
def test_impossible_paths_are_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError, match=f"^hand path: {words}"):
        HandPath(**wrong)
