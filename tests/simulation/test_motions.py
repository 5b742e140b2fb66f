"""What the person, or the robot's commander, intends: what holds for every motion, and each by hand."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from friction_audit.simulation.periodic import Commanded, MotionSettings, Sinusoid, frequencies_hz
from friction_audit.simulation.strokes import HandPath, SlowSweep, StopAndGo, plan_hand

DT = 1e-3
TICKS = 20_000


def _rng(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


every_motion = pytest.mark.parametrize("motion", get_args(MotionSettings))


@every_motion
def test_starts_and_ends_at_rest(motion: type[MotionSettings]) -> None:
    intention = motion().reference(TICKS, DT, _rng(1))
    assert intention.position.shape == intention.velocity.shape == (TICKS + 1,)
    assert intention.position[0] == intention.velocity[0] == intention.velocity[-1] == 0.0
    assert np.ptp(intention.position) > 0.1
    short = motion().reference(2, DT, _rng(4))  # too short for any motion
    assert np.abs(short.position).max() <= 0.8
    assert_allclose(short.velocity[[0, -1]], 0.0, atol=0)


@every_motion
def test_velocity_is_the_derivative_of_the_position(motion: type[MotionSettings]) -> None:
    """The central difference of a tenth of the step is a hundred times closer, but for the jumps of acceleration."""
    error = []
    for dt in (DT, DT / 10):
        ticks = round(TICKS * DT / dt)
        intention = motion().reference(ticks, dt, _rng(2))
        slope = (intention.position[2:] - intention.position[:-2]) / (2 * dt)
        error.append(np.median(np.abs(slope - intention.velocity[1:-1])[intention.velocity[1:-1] != 0.0]))
        assert_allclose(slope, intention.velocity[1:-1], atol=dt)
    coarse, fine = error
    assert fine <= 0.011 * coarse + 1e-11


RANGE = st.tuples(st.floats(-2.0, -0.45), st.floats(0.45, 2.0))
BOUNDED = st.one_of(
    st.builds(
        StopAndGo, range_rad=RANGE, reversing=st.floats(0.0, 1.0), speed_rad_s=st.floats(0.05, 2.0),
        speed_limits_rad_s=st.tuples(st.floats(0.05, 0.5), st.floats(0.5, 2.0)),
    ),
    st.builds(
        SlowSweep, range_rad=RANGE, speeds_rad_s=st.tuples(st.just(0.01), st.floats(0.02, 2.0)),
        reversals=st.integers(0, 8), steps=st.integers(1, 12),
    ),
    st.builds(Commanded, range_rad=RANGE, sines=st.integers(1, 9), peak_speed_rad_s=st.floats(0.01, 3.0)),
)  # fmt: skip


@given(motion=BOUNDED, seed=st.integers(0, 2**32 - 1), ticks=st.integers(2, 10_000))
@settings(max_examples=80, deadline=None)
def test_range_and_speed_limits_hold(motion: StopAndGo | SlowSweep | Commanded, seed: int, ticks: int) -> None:
    intention, (low, high) = motion.reference(ticks, 4e-3, _rng(seed)), motion.range_rad
    if isinstance(motion, Commanded):
        fastest = motion.peak_speed_rad_s
    elif isinstance(motion, SlowSweep):
        fastest = max(motion.speeds_rad_s[1], 3e-2 / 0.5)
    else:
        fastest = motion.speed_limits_rad_s[1]
    position, speed = intention.position, np.abs(intention.velocity).max()
    shares = (position.min() / low, position.max() / high, speed / fastest)
    assert max(shares) <= 1.0 + 1e-9
    # A multisine is scaled until it meets one of its bounds.
    assert max(shares) >= 1.0 - 1e-9 or not isinstance(motion, Commanded)


def _intend(sinusoid: Sinusoid, duration_s: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    ticks = round(duration_s / DT)
    return np.arange(ticks + 1) * DT, *sinusoid.reference(ticks, DT, _rng(seed))


def test_paper_s_sinusoid() -> None:
    t, position, velocity = _intend(Sinusoid(amplitude_rad=0.5, period_s=4.0), 12.0)
    assert_allclose(position, 0.5 * (1 - np.cos(np.pi / 2 * t)), atol=1e-12)
    assert_allclose(velocity, np.pi / 4 * np.sin(np.pi / 2 * t), atol=1e-12)
    assert_allclose(velocity[::2000], 0.0, atol=1e-12)


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


def test_one_speed_by_hand() -> None:
    """0.1 rad/s for 2 s to one side and back, then to the other; a stroke lasts 2 s and one ease."""
    sweep = SlowSweep(speeds_rad_s=(0.1, 0.1), steps=1, longest_s=2.0, ease_s=0.5, dwell_s=0.5)
    intention = sweep.reference(14_000, DT, _rng(0))
    t = np.arange(14_001) * DT
    going = (t > 1.0 + 1e-9) & (t < 2.5 - 1e-9)
    assert_allclose(intention.velocity[going], -0.1, rtol=1e-12)
    assert_allclose(intention.position[[3000, 3500, 6000, 6500]], [-0.2, -0.2, 0.0, 0.0], atol=1e-12)
    assert_allclose(intention.position[[9000, 12_000]], [0.2, 0.0], atol=1e-12)
    assert_array_equal(intention.velocity[12_000:], 0.0)


def test_frequencies_by_hand() -> None:
    """The primes 2, 19, 47, 79 and 109 for the first of seven joints; 3 first for the second."""
    expected = np.sqrt(np.array([2, 19, 47, 79, 109]) / 2)
    frequencies = frequencies_hz(Commanded(lowest_hz=1.0), 7)
    assert_allclose(frequencies[0], expected)
    assert_allclose(frequencies[1, 0], np.sqrt(1.5))
    assert_array_equal(frequencies_hz(Commanded(lowest_hz=1.0), 1), frequencies[:1])
    assert len(np.unique(frequencies)) == 35
    assert len(np.unique(frequencies_hz(Commanded(sines=1), 20))) == 20


@pytest.mark.parametrize("rotation_rad", [1e-5, 0.6, 3.0])
def test_velocities_are_the_derivatives(rotation_rad: float) -> None:
    hand = plan_hand(HandPath(rotation_rad=rotation_rad), TICKS, DT, _rng(1))
    slopes = (hand.position[2:] - hand.position[:-2]) / (2 * DT)
    assert_allclose(slopes, hand.velocity[1:-1], atol=1e-5)
    orientation = Rotation.from_rotvec(hand.rotation)
    turned = (orientation[2:] * orientation[:-2].inv()).as_rotvec() / (2 * DT)
    assert_allclose(turned, hand.angular[1:-1], atol=2e-5 * rotation_rad)


@given(
    seed=st.integers(0, 2**32 - 1),
    reach=st.floats(0.01, 0.5),
    sideways=st.floats(0.5, 3.0),
    rotation=st.floats(0.0, 3.0),
    fastest=st.floats(0.1, 2.0),
    turning=st.floats(0.1, 3.0),
)
@settings(max_examples=30, deadline=None)
def test_bounds_of_a_hand_hold(
    seed: int, reach: float, sideways: float, rotation: float, fastest: float, turning: float
) -> None:
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
