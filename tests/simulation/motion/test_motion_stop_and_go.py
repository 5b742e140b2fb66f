from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from friction_audit.errors import UsageError
from friction_audit.simulation.motion.strokes import PEAK, StopAndGo, plan_strokes

USUAL = StopAndGo()


def test_the_first_stroke_starts_stops_and_is_fastest_half_way() -> None:
    start, lasts, origin, length = plan_strokes(USUAL, 10.0, _rng(5))[0]
    motion = USUAL.intend(100_000, 1e-4, _rng(5))
    begin, middle, end = (round(1e4 * (start + share * lasts)) for share in (0.0, 0.5, 1.0))
    assert_allclose(motion.position[[begin, middle, end]], origin + length * np.array([0.0, 0.5, 1.0]), atol=1e-3)
    assert_allclose(motion.velocity[[begin, middle, end]], [0.0, PEAK * length / lasts, 0.0], atol=1e-3)


def test_strokes_of_a_seed_stay_the_same() -> None:
    """The committed sample logs and benchmark tables depend on them."""
    strokes = plan_strokes(USUAL, 10.0, np.random.default_rng(5))
    table = strokes[:, [0, 1, 3]].T
    assert table.shape == (3, 5)
    assert table[:, 0] == pytest.approx([0.5, 1.3437207168585683, -0.8773761539252232], rel=1e-9)
    assert table[:, -1] == pytest.approx([7.447505816635416, 0.9166654959031897, 0.38676348599823623], rel=1e-9)


def test_mean_and_spread_of_the_peak_speeds() -> None:
    strokes = plan_strokes(replace(USUAL, speed_limits_rad_s=(0.01, 9.0), range_rad=(-30.0, 30.0)), 3600.0, _rng(6))
    speeds = PEAK * np.abs(strokes[:, 3]) / strokes[:, 1]
    assert_allclose(speeds.mean(), 0.9, rtol=0.02)
    assert_allclose(speeds.std() / speeds.mean(), 0.4, rtol=0.05)


@given(
    seed=st.integers(0, 2**32 - 1),
    speed=st.floats(0.05, 2.0),
    low=st.floats(-2.0, 0.0),
    high=st.floats(0.05, 2.0),
    reversing=st.floats(0.0, 1.0),
)
@settings(max_examples=50, deadline=None)
def test_range_and_speed_limits_hold(seed: int, speed: float, low: float, high: float, reversing: float) -> None:
    limits = (speed / 2, speed * 2)
    moved = StopAndGo(speed_rad_s=speed, speed_limits_rad_s=limits, range_rad=(low, high), reversing=reversing)
    intention = moved.intend(5000, 2e-3, _rng(seed))
    assert low - 1e-9 <= intention.position.min() <= intention.position.max() <= high + 1e-9
    assert np.abs(intention.velocity).max() <= limits[1] * (1 + 1e-9)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"speed_rad_s": 0.0}, "speed_rad_s 0: expected a number above zero"),
        ({"speed_rad_s": float("nan")}, "speed_rad_s nan"),
        ({"speed_spread": -0.1}, "speed_spread -0.1: expected zero or more"),
        ({"pause_s": (-1.0, 1.0)}, "shortest_pause_s -1"),
        ({"stroke_s": (0.0, 1.0)}, "shortest_stroke_s 0"),
        ({"stroke_s": (2.0, 1.0)}, "stroke_s 2, 1: expected the smaller number first"),
        ({"speed_limits_rad_s": (0.0, 1.0)}, "slowest_rad_s 0"),
        ({"range_rad": (0.1, 1.0)}, "range_rad 0.1, 1: expected a range around the start at 0"),
        ({"range_rad": (0.0, 0.0)}, "range_rad 0, 0"),
        ({"reversing": 1.5}, "reversing 1.5: expected a number from 0 to 1"),
    ],
)
def test_impossible_settings_are_refused(wrong: dict[str, float], words: str) -> None:
    with pytest.raises(UsageError, match=f"^stop-and-go: {words}"):
        StopAndGo(**wrong)  # type: ignore[arg-type]


def _rng(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)
