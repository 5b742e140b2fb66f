from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulation.motion import SlowSweep

DT = 1e-3
USUAL = SlowSweep()


def _rng(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_one_speed_by_hand() -> None:
    """0.1 rad/s for 2 s to one side and back, then to the other; a stroke lasts 2 s and one ease."""
    sweep = SlowSweep(speeds_rad_s=(0.1, 0.1), steps=1, longest_s=2.0, ease_s=0.5, dwell_s=0.5)
    intention = sweep.intend(14_000, DT, _rng(0))
    t = np.arange(14_001) * DT
    going = (t > 1.0 + 1e-9) & (t < 2.5 - 1e-9)
    assert_allclose(intention.velocity[going], -0.1, rtol=1e-12)
    assert_allclose(intention.position[[3000, 3500, 6000, 6500]], [-0.2, -0.2, 0.0, 0.0], atol=1e-12)
    assert_allclose(intention.position[[9000, 12_000]], [0.2, 0.0], atol=1e-12)
    assert_array_equal(intention.velocity[12_000:], 0.0)


def test_a_pass_of_a_minute_has_every_speed_in_both_directions() -> None:
    for seed in range(5):
        intention = USUAL.intend(60_000, DT, _rng(seed))
        for speed in np.geomspace(0.01, 1.0, 7):
            for signed in (speed, -speed):
                assert np.isclose(intention.velocity, signed, rtol=1e-9).sum() > 100


def test_small_reversals_are_small_and_come_back() -> None:
    sweep = replace(USUAL, reversals=20)
    intention = sweep.intend(22_000, DT, _rng(1))
    turns = np.flatnonzero(np.diff(np.sign(intention.velocity[:20_800])) != 0)
    ways = np.abs(np.diff(intention.position[turns]))
    ways = ways[ways > 1e-9]
    assert len(ways) >= 20
    assert ways.max() <= 3e-2 + 1e-12
    assert np.sort(ways)[2] >= 1e-3
    assert abs(intention.position[21_500]) < 1e-12


@given(
    seed=st.integers(0, 2**32 - 1),
    fastest=st.floats(0.02, 2.0),
    low=st.floats(0.45, 2.0),
    high=st.floats(0.45, 2.0),
    reversals=st.integers(0, 8),
    steps=st.integers(1, 12),
)
@settings(max_examples=30, deadline=None)
def test_range_and_speeds_hold(seed: int, fastest: float, low: float, high: float, reversals: int, steps: int) -> None:
    sweep = SlowSweep(speeds_rad_s=(0.01, fastest), range_rad=(-low, high), reversals=reversals, steps=steps)
    intention = sweep.intend(10_000, 4e-3, _rng(seed))
    assert -low - 1e-9 <= intention.position.min()
    assert intention.position.max() <= high + 1e-9
    assert np.abs(intention.velocity).max() <= max(fastest, 3e-2 / 0.5) + 1e-9
    assert abs(intention.position[-1]) < 1e-9
    assert intention.velocity[-1] == 0.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"speeds_rad_s": (0.0, 1.0)}, "slowest_rad_s 0: expected a number above zero"),
        ({"speeds_rad_s": (1.0, 0.5)}, "speeds_rad_s 1, 0.5: expected the smaller number first"),
        ({"steps": 0}, "steps 0"),
        ({"reversals": -1}, "reversals -1: expected a number from 0 to 1000"),
        ({"ease_s": 4.0}, "ease_s 4: expected at most 3, longest_s or, with reversals, reversal_s"),
        ({"ease_s": 0.6, "reversals": 2}, "ease_s 0.6: expected at most 0.5"),
        ({"range_rad": (-0.1, 0.6)}, "range_rad -0.1, 0.6: expected a range around the start at 0, from -0.2 or less"),
        ({"range_rad": (-0.3, 0.3), "reversals": 2, "reversal_rad": (0.1, 1.0)}, "range_rad -0.3, 0.3"),
    ],
)
def test_impossible_sweeps_are_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError, match=f"^slow-sweep: {words}"):
        SlowSweep(**wrong)
