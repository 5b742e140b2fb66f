import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulation.motion import Sinusoid

DT = 1e-3


def _intend(sinusoid: Sinusoid, duration_s: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    ticks = round(duration_s / DT)
    intention = sinusoid.intend(ticks, DT, np.random.default_rng(seed))
    return np.arange(ticks + 1) * DT, intention.position, intention.velocity


def test_paper_s_sinusoid() -> None:
    t, position, velocity = _intend(Sinusoid(amplitude_rad=0.5, period_s=4.0), 12.0)
    assert_allclose(position, 0.5 * (1 - np.cos(np.pi / 2 * t)), atol=1e-12)
    assert_allclose(velocity, np.pi / 4 * np.sin(np.pi / 2 * t), atol=1e-12)
    assert_allclose(velocity[::2000], 0.0, atol=1e-12)


def test_rests_after_the_last_half_period_that_fits() -> None:
    t, position, velocity = _intend(Sinusoid(period_s=4.0), 7.0)
    assert_array_equal(velocity[t >= 6.0], 0.0)
    assert_allclose(position[t >= 6.0], 1.0)
    assert_array_equal(_intend(Sinusoid(period_s=4.0), 1.5)[1], 0.0)


def test_smooth_start_comes_late_by_half_its_time() -> None:
    t, position, velocity = _intend(Sinusoid(period_s=4.0, ease_s=2.0), 13.0)
    late = t >= 2.0
    assert_allclose(position[late], 0.5 * (1 - np.cos(np.pi / 2 * (t[late] - 1.0))), atol=1e-12)
    assert np.abs(velocity[:100]).max() < 1e-5
    assert velocity[-1] == 0.0


@given(seed=st.integers(0, 2**32 - 1), spread=st.floats(0.0, 0.5), ease_s=st.sampled_from([0.0, 1.0, 3.0]))
@settings(max_examples=30, deadline=None)
def test_spread_keeps_the_half_periods(seed: int, spread: float, ease_s: float) -> None:
    """Whatever the spread, the speed vanishes and changes its sign at the ends of the half-periods and nowhere else."""
    t, position, velocity = _intend(Sinusoid(spread=spread, ease_s=ease_s), 20.0 + ease_s / 2, seed)
    halves = np.maximum(t - ease_s / 2, 0.0) / 2.0
    inside = (t > ease_s) & (np.abs(halves - np.rint(halves)) > 1e-3)
    assert_array_equal(np.sign(velocity[inside]), np.where(np.floor(halves[inside]) % 2 == 0, 1.0, -1.0))
    assert -0.5 * spread - 1e-12 <= position.min()
    assert position.max() <= 1.0 + 0.5 * spread + 1e-12
    assert_allclose(np.gradient(position, DT)[1:-1], velocity[1:-1], atol=1e-3)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"amplitude_rad": 0.0}, "amplitude_rad 0: expected a number above zero"),
        ({"period_s": float("inf")}, "period_s inf"),
        ({"spread": 0.6}, "spread 0.6: expected a number from 0 to 0.5"),
        ({"ease_s": -1.0}, "ease_s -1: expected zero or more"),
    ],
)
def test_impossible_sinusoids_are_refused(wrong: dict[str, float], words: str) -> None:
    with pytest.raises(UsageError, match=f"^sinusoid: {words}"):
        Sinusoid(**wrong)
