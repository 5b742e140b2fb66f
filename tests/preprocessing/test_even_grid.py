"""A log on an even grid: the low-pass, stamps on the ticks of a clock, gaps and stale samples."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from scipy.signal import lfilter

from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing import even_grid
from friction_audit.preprocessing.balance import Grid, GridTorque, grids_of, motion_on
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.robot.arm import load_arm
from tests.synthetic_interaction import log_of

STEP = 1e-3


def test_a_slow_sine_passes_with_its_derivative() -> None:
    t = np.arange(0, 5, 1e-3)
    low_pass = even_grid.LowPass.for_stamps(t)
    slow, slope = low_pass.with_slope(t, np.sin(4 * np.pi * t))
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    assert np.abs(slow - np.sin(4 * np.pi * low_pass.t))[inside].max() < 1e-3
    assert np.abs(slope - 4 * np.pi * np.cos(4 * np.pi * low_pass.t))[inside].max() < 2e-2


def test_a_position_bends_over_lost_samples() -> None:
    t = np.delete(np.arange(0, 5, 1e-3), np.arange(2000, 2009))
    low_pass = even_grid.LowPass.for_stamps(t)
    _, slope = low_pass.with_slope(t, 5.0 * t**2)
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    # A straight line over 10 ms would be off by 0.125 mrad, and its slope by 14 mrad/s.
    assert np.abs(slope - 10.0 * low_pass.t)[inside].max() < 1e-3


def test_samples_of_an_earlier_moment_are_found_by_the_motion() -> None:
    rng, t = np.random.default_rng(0), np.arange(0, 5, STEP)
    times = t.copy()
    times[37::50] -= 0.6 * STEP
    q, dq = np.sin(4 * times) + 4e-6 * rng.standard_normal(len(t)), 4 * np.cos(4 * times)
    at_rest = np.zeros_like(t)
    found = even_grid.belated_samples(t, np.column_stack([q, at_rest]), np.column_stack([dq, at_rest]))
    turning = np.abs(dq) < 0.2
    np.testing.assert_array_equal(found[~turning], (times < t)[~turning])
    assert not even_grid.belated_samples(t, at_rest[:, None], at_rest[:, None]).any()


@pytest.mark.parametrize(("frequency", "gain"), [(40.0, 1.0), (80.0, 0.5), (130.0, 0.0)])
def test_corner(frequency: float, gain: float) -> None:
    t = np.arange(0, 5, 2.5e-4)
    low_pass = even_grid.LowPass.for_stamps(t)
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    passed = low_pass.of(t, np.sin(2 * np.pi * frequency * t + 0.7))[inside]
    assert np.sqrt(2 * np.mean(passed**2)) == pytest.approx(gain, abs=0.01)


@pytest.mark.parametrize(
    ("rate", "grid", "corner"), [(50.0, 50.0, 12.5), (300.0, 300.0, 75.0), (500.0, 400.0, 80.0), (1000.0, 400.0, 80.0)]
)
def test_grid_is_not_faster_than_the_log(rate: float, grid: float, corner: float) -> None:
    t = np.arange(0, 5, 1 / rate)
    low_pass = even_grid.LowPass.for_stamps(t)
    assert 1 / (low_pass.t[1] - low_pass.t[0]) == pytest.approx(grid)
    assert low_pass.corner_hz == pytest.approx(corner)
    assert (low_pass.t[0], low_pass.t[-1]) == pytest.approx((0.0, t[-1]), abs=1 / grid)
    assert low_pass.of(t, np.ones(len(t))) == pytest.approx(1.0)


def test_gaps_are_those_that_motion_bends_in() -> None:
    t = np.delete(np.arange(2000) * 1e-3, [*range(500, 515), *range(900, 925)])
    (gap,) = even_grid.gaps(t)
    assert t[gap] == pytest.approx(0.899)


def test_a_stale_sample_of_a_moving_joint_is_stale_and_that_of_a_resting_one_is_not() -> None:
    t: Float = np.arange(500.0) * STEP
    q, dq = np.sin(t), np.cos(t)
    q[101], dq[101] = q[100], dq[100]
    assert np.flatnonzero(~even_grid.fresh_samples(log_of(t, q, dq, tau_J=0.0 * t))).tolist() == [101]
    assert even_grid.fresh_samples(log_of(t, np.full_like(q, 0.3), 0.0 * t, tau_J=0.0 * t)).all()


def test_a_state_that_is_read_in_coarse_steps_repeats_and_is_not_stale() -> None:
    t: Float = np.arange(5000.0) * STEP
    q, dq = np.round(0.05 * np.sin(2.0 * t), 3), 0.05 * np.round(2.0 * np.cos(2.0 * t))  # 0.1 of 1 mrad in a sample
    assert np.mean((np.diff(q) == 0) & (np.diff(dq) == 0) & (dq[1:] != 0)) > 0.5
    assert even_grid.fresh_samples(log_of(t, q, dq, tau_J=0.0 * t)).all()


def off_ticks(steady: Float, tick: Float) -> float:
    """Largest distance from the true ticks, a constant lateness taken away. [s]"""
    late = steady - tick
    return float(np.abs(late - np.median(late)).max())


@settings(max_examples=25)
@example(seed=0, jitter=0.0, lost=0.0, rate=1000)
@given(
    seed=st.integers(0, 1000), jitter=st.floats(0.0, 0.3), lost=st.floats(0.0, 0.1), rate=st.sampled_from([250, 1000])
)
def test_late_stamps_go_to_their_ticks_and_lost_ticks_stay_lost(
    seed: int, jitter: float, lost: float, rate: int
) -> None:
    rng = np.random.default_rng(seed)
    tick: Float = np.flatnonzero(rng.random(4000) >= lost).astype(np.float64) / rate
    t: Float = (tick + rng.uniform(0, jitter, len(tick)) / rate).astype(np.float64)
    steady = even_grid.steady_clock(t)
    # The mean lateness over half a second, n samples of a uniform distribution, is known to jitter / sqrt(12 n).
    assert off_ticks(steady, tick) <= 1e-9 + 8 * jitter / rate / np.sqrt(12 * 0.25 * rate)
    assert np.array_equal(np.round(np.diff(steady) * rate), np.round(np.diff(tick) * rate))


def test_a_clock_that_drifts_is_followed() -> None:
    rng = np.random.default_rng(1)
    k = np.arange(20_000)
    tick = STEP * (1 + 3e-5) * k + 2e-4 * np.sin(2 * np.pi * k / 20_000)
    steady = even_grid.steady_clock(tick + rng.uniform(0, 2e-4, len(tick)))
    inside = slice(300, -300)
    assert off_ticks(steady[inside], tick[inside]) < 3e-5


@pytest.mark.parametrize("rate", [500, 1000])
def test_a_stamp_nearer_to_the_next_tick_goes_back_to_its_own(rate: int) -> None:
    rng = np.random.default_rng(4)
    tick = np.flatnonzero(rng.random(20_000) >= 0.03) / rate
    late = np.minimum(rng.exponential(1.9e-4, len(tick)), 0.8 / rate)
    steady = even_grid.steady_clock(tick + late)
    apart = np.abs(steady - tick - np.median(steady - tick))
    assert np.mean(late > 0.5 / rate) > 2e-3
    # One whose next tick was lost cannot be seen to be late by that, but it would be far earlier than any other.
    assert not np.any(apart > 0.4 / rate)
    assert np.median(apart) < 2e-5


def test_late_stamps_do_not_stretch_the_period() -> None:
    rng = np.random.default_rng(5)
    tick = np.flatnonzero(rng.random(60_000) >= 0.06) * STEP
    late = even_grid.steady_clock(tick + rng.exponential(1.9e-4, len(tick)).clip(max=0.8e-3)) - tick
    assert np.ptp(np.polyval(np.polyfit(tick, late, 1), tick[[0, -1]])) < 1e-4


def test_stamps_without_a_clock_and_a_handful_stay_as_they_are() -> None:
    rng = np.random.default_rng(2)
    for t in (np.cumsum(rng.exponential(STEP, 3000)), STEP * np.arange(99) + rng.uniform(0, 1e-4, 99)):
        assert even_grid.steady_clock(t) is t


@pytest.mark.parametrize("samples_are_late", [False, True])
def test_the_position_shows_whether_samples_are_as_late_as_their_stamps(samples_are_late: bool) -> None:
    rng = np.random.default_rng(5)
    tick = np.arange(20_000) * STEP
    t = tick + rng.exponential(1e-4, len(tick)).clip(max=0.8e-3)
    taken = t if samples_are_late else tick
    q = np.column_stack([np.sin(taken), 0.5 * np.sin(2.0 * taken)]) + rng.normal(scale=1e-6, size=(len(tick), 2))
    times = even_grid.times_of_samples(t, q, np.column_stack([np.cos(taken), np.cos(2.0 * taken)]))
    assert np.std(times - taken) < 0.2 * np.std(t - tick)


@pytest.mark.parametrize(("pole", "before"), [(0.97, 0.3), (0.97 * np.exp(0.1j), 0.2 - 0.1j)])
def test_the_first_order_filter_is_that_of_scipy(pole: complex, before: complex) -> None:
    signal = np.random.default_rng(0).standard_normal(200).astype(type(pole))
    expected = lfilter([1.0 - pole], [1.0, -pole], signal, zi=[pole * before])[0]
    assert even_grid.first_order(signal, pole, before) == pytest.approx(expected, rel=1e-12)


# The model's torque on a coarse grid against the same at every sample.

RATE_HZ = TorqueSettings().model_rate_hz
CENTRE = np.array([0.0, -0.8, 0.0, -2.3, 0.0, 1.5, 0.8])
AMPLITUDE = np.array([0.5, 0.4, 0.5, 0.4, 0.5, 0.5, 0.6])
FREQUENCY_HZ = np.array([0.5, 0.7, 0.9, 1.1, 0.6, 0.8, 1.0])


def moving_arm(t: Float) -> tuple[JointLog, Float]:
    """A log of smooth motion, up to 3 rad/s, and its exact acceleration."""
    omega = 2 * np.pi * FREQUENCY_HZ
    phase = t[:, None] * omega
    q, dq = CENTRE + AMPLITUDE * np.sin(phase), AMPLITUDE * omega * np.cos(phase)
    return log_of(t, q, dq, tau_J=np.zeros((len(t), 7))), -AMPLITUDE * omega**2 * np.sin(phase)


def at_samples(log: JointLog, torque: Callable[[Grid], Float], columns: Sequence[int] = range(7)) -> Float:
    """Return at every sample the torque of some joints that is given on grids."""
    grids, found = grids_of(log, RATE_HZ), np.zeros((len(log.t), len(columns)))
    made = GridTorque(grids=grids, values=tuple(map(torque, grids)))
    made.subtract_from(found, log.t, list(columns))
    return -found


def jittered(rate_hz: float, seconds: float) -> Float:
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.8, 1.2, int(rate_hz * seconds))) / rate_hz
    return np.asarray(t - t[0])


def test_inverse_dynamics_from_the_grid_is_within_a_hundredth_of_the_inertial_torque() -> None:
    log, ddq = moving_arm(jittered(1000.0, 6.0))
    arm = load_arm()
    exact = arm.inverse_dynamics(log.q, log.dq, ddq)
    torque = at_samples(log, lambda grid: arm.inverse_dynamics(*motion_on((grid,), log)[0]))
    inside = (log.t > 0.5) & (log.t < log.t[-1] - 0.5)
    moving = np.abs(exact - arm.gravity(log.q)).max(axis=0)
    assert (np.abs(torque - exact)[inside].max(axis=0) < np.maximum(0.01, 0.01 * moving)).all()


@pytest.mark.parametrize("rate_hz", [30.0, 12.0, 3.0])
def test_a_log_slower_than_the_filter_is_still_followed(rate_hz: float) -> None:
    log, _ = moving_arm(np.arange(0.0, 8.0, 1 / rate_hz))
    (grid,) = grids_of(log, RATE_HZ)
    _, velocity, acceleration = motion_on((grid,), log)[0]
    assert len(grid.t) <= len(log.t) + 1
    assert np.abs(velocity).max() < 1.2 * np.abs(log.dq).max()
    assert np.isfinite(acceleration).all()


def test_nothing_crosses_a_hole_in_the_log() -> None:
    log, _ = moving_arm(np.concatenate([np.arange(0.0, 2.0, 0.001), np.arange(1000.0, 1002.0, 0.001)]))
    grids = grids_of(log, RATE_HZ)
    assert [(round(grid.t[0]), round(grid.t[-1])) for grid in grids] == [(0, 2), (1000, 1002)]
    assert sum(len(grid.t) for grid in grids) < 410
    arm = load_arm()
    torque = at_samples(log, lambda grid: arm.gravity(motion_on((grid,), log)[0][0]), [1, 3])
    assert np.abs(torque - arm.gravity(log.q)[:, [1, 3]]).max() < 0.01


@pytest.mark.parametrize("samples", [3, 4, 5, 40])
def test_very_short_logs_and_lone_samples(samples: int) -> None:
    log, _ = moving_arm(np.concatenate([np.arange(samples) * 0.001, [60.0]]))
    assert all(np.isfinite(array).all() for motion in motion_on(grids_of(log, RATE_HZ), log) for array in motion)
    np.testing.assert_allclose(at_samples(log, lambda grid: motion_on((grid,), log)[0][0]), log.q, atol=1e-3)
