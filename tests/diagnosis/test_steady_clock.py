"""Stamps that another computer wrote go back to the ticks of the robot's clock."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.diagnosis.steady_clock import steady_clock
from friction_audit.joint_log import Float

STEP = 1e-3


def off_ticks(steady: Float, tick: Float) -> float:
    """Largest distance from the true ticks, a constant lateness taken away. [s]"""
    late = steady - tick
    return float(np.abs(late - np.median(late)).max())


def test_even_stamps_stay() -> None:
    t = 5.0 + STEP * np.arange(3000.0)
    assert steady_clock(t) == pytest.approx(t, abs=1e-9)


@settings(max_examples=25)
@given(
    seed=st.integers(0, 1000), jitter=st.floats(0.0, 0.3), lost=st.floats(0.0, 0.1), rate=st.sampled_from([250, 1000])
)
def test_late_stamps_go_to_their_ticks_and_lost_ticks_stay_lost(
    seed: int, jitter: float, lost: float, rate: int
) -> None:
    rng = np.random.default_rng(seed)
    tick: Float = np.flatnonzero(rng.random(4000) >= lost).astype(np.float64) / rate
    t: Float = (tick + rng.uniform(0, jitter, len(tick)) / rate).astype(np.float64)
    steady = steady_clock(t)
    # The mean lateness over half a second, n samples of a uniform distribution, is known to jitter / sqrt(12 n).
    assert off_ticks(steady, tick) <= 1e-9 + 8 * jitter / rate / np.sqrt(12 * 0.25 * rate)
    assert np.array_equal(np.round(np.diff(steady) * rate), np.round(np.diff(tick) * rate))


def test_a_gap_of_two_ticks_is_two_ticks_long() -> None:
    rng = np.random.default_rng(0)
    tick = np.delete(np.arange(2000), [500, 901, 902]) * STEP
    steps = np.diff(steady_clock(tick + rng.uniform(0, 2e-4, len(tick))))
    assert np.flatnonzero(np.round(steps / STEP) > 1).tolist() == [499, 899]
    assert steps[[499, 899]] == pytest.approx([2 * STEP, 3 * STEP], abs=2e-5)


def test_a_clock_that_drifts_is_followed() -> None:
    rng = np.random.default_rng(1)
    k = np.arange(20_000)
    tick = STEP * (1 + 3e-5) * k + 2e-4 * np.sin(2 * np.pi * k / 20_000)
    steady = steady_clock(tick + rng.uniform(0, 2e-4, len(tick)))
    inside = slice(300, -300)
    assert off_ticks(steady[inside], tick[inside]) < 3e-5


@pytest.mark.parametrize("rate", [500, 1000])
def test_a_stamp_nearer_to_the_next_tick_goes_back_to_its_own(rate: int) -> None:
    rng = np.random.default_rng(4)
    tick = np.flatnonzero(rng.random(20_000) >= 0.03) / rate
    late = np.minimum(rng.exponential(1.9e-4, len(tick)), 0.8 / rate)
    steady = steady_clock(tick + late)
    apart = np.abs(steady - tick - np.median(steady - tick))
    assert np.mean(late > 0.5 / rate) > 2e-3
    # One whose next tick was lost has nobody who tells that it is late, but it would be far earlier than any other.
    assert not np.any(apart > 0.4 / rate)
    assert np.median(apart) < 2e-5


def test_late_stamps_do_not_stretch_the_period() -> None:
    rng = np.random.default_rng(5)
    tick = np.flatnonzero(rng.random(60_000) >= 0.06) * STEP
    late = steady_clock(tick + rng.exponential(1.9e-4, len(tick)).clip(max=0.8e-3)) - tick
    assert np.ptp(np.polyval(np.polyfit(tick, late, 1), tick[[0, -1]])) < 1e-4


def test_stamps_without_a_clock_stay_as_they_are() -> None:
    t = np.cumsum(np.random.default_rng(2).exponential(STEP, 3000))
    assert steady_clock(t) is t


def test_a_handful_of_stamps_shows_no_clock() -> None:
    t = STEP * np.arange(99) + np.random.default_rng(3).uniform(0, 1e-4, 99)
    assert steady_clock(t) is t
