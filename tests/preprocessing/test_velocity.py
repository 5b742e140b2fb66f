"""The filtered velocity, one that a driver's filter delays, and the mean of two."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose
from scipy.signal import butter, lfilter, sosfiltfilt

from friction_audit.joint_log import Float, JointLog, median_step
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.preprocessing import velocity
from friction_audit.preprocessing.sign import coarse_log
from friction_audit.reporting.notices import sentence_of
from tests.effects.joint_data_by_hand import sines
from tests.synthetic_interaction import log_of

STEP_S = 0.001
T: Float = np.arange(30_000, dtype=np.float64) * STEP_S


def motion() -> tuple[Float, Float]:
    """Position and velocity of three sinusoids."""
    return sines(T, (0.6, 2.0, 0.0), (0.2, 5.0, 1.0), (0.05, 11.0, 2.0))[:2]


def log_with(dq: Float, q: Float | None = None) -> JointLog:
    return log_of(T, motion()[0] if q is None else q, dq, tau_interaction=0.3 * np.sign(motion()[1]))


def lag_ms(log: JointLog) -> float:
    return 1e3 * float(velocity.find_lag(coarse_log(log), median_step(log.t))[0])


@pytest.mark.parametrize("lag_s", [0.002, 0.006, 0.02])
def test_a_pure_delay_is_found_and_undone(lag_s: float) -> None:
    dq = motion()[1]
    late = log_with(np.interp(T - lag_s, T, dq))
    assert lag_ms(late) == pytest.approx(1e3 * lag_s, rel=0.05)
    mended = velocity.on_time(late, coarse_log(late))[0].dq[100:-100, 0]
    assert np.abs(mended - dq[100:-100]).max() < 0.03 * np.abs(dq).max()


def test_a_filtered_difference_is_replaced_by_a_centred_one() -> None:
    q, dq = motion()
    pole = np.exp(-2 * np.pi * 30.0 * STEP_S)
    filtered = lfilter([1 - pole], [1, -pole], np.diff(q, prepend=q[0]) / STEP_S)
    mended = velocity.on_time(log_with(filtered), coarse_log(log_with(filtered)))[0].dq[100:-100, 0]
    assert np.sqrt(np.mean((mended - dq[100:-100]) ** 2)) < 0.1 * np.sqrt(np.mean((filtered - dq)[100:-100] ** 2))


def test_a_steady_motion_has_its_velocity_to_both_ends() -> None:
    mended = velocity.read_on_time(log_with(np.full(len(T), 0.4), 0.4 * T), np.array([0.006]))
    np.testing.assert_allclose(mended.dq, 0.4, rtol=1e-9)


def test_a_coarse_position_makes_no_velocity() -> None:
    q, dq = motion()
    log = log_with(np.interp(T - 0.005, T, dq), np.round(q / 0.02) * 0.02)
    mended = velocity.read_on_time(log, np.array([0.005])).dq[100:-100, 0]
    assert_allclose(mended, dq[100:-100], rtol=0.0, atol=1e-3)


@pytest.mark.parametrize(("lag_s", "noise"), [(0.0, 0.0), (-0.006, 0.0), (0.0004, 0.0), (0.0, 0.02)])
def test_a_velocity_that_is_not_late_stays_as_it_is(lag_s: float, noise: float) -> None:
    log = log_with(np.interp(T - lag_s, T, motion()[1]) + noise * np.random.default_rng(1).standard_normal(len(T)))
    same, cautions = velocity.on_time(log, coarse_log(log))
    assert same is log
    assert cautions == ()


def test_noise_of_the_position_does_not_make_the_lag_smaller() -> None:
    q, dq = motion()
    noisy = q + 3e-3 * np.random.default_rng(2).standard_normal(len(T))
    assert lag_ms(log_with(np.interp(T - 0.006, T, dq), noisy)) == pytest.approx(6.0, rel=0.1)


def test_each_joint_is_put_on_time_by_its_own_lag() -> None:
    """Of three joints the first is 2 ms late, the third 6 ms; the second is left as it is."""
    q, dq = motion()
    lags = (0.002, 0.0, 0.006)
    alone = log_with(dq)
    columns: dict[str, Any] = {
        "dq": np.stack([np.interp(T - lag, T, dq) for lag in lags], axis=1),
        "q": np.stack([q] * 3, axis=1),
    }
    columns["tau_interaction"] = np.repeat(alone.channels()["tau_interaction"], 3, axis=1)
    log = replace(alone, joint_names=("hip", "knee", "ankle"), **columns)
    mended = estimate_log(log, AuditSettings()).interaction
    (caution,) = [one for one in mended.warnings if one.code == "dq_late"]
    assert sentence_of(caution) == "joints 1, 3: dq lags q by 2.0 to 6.0 ms (velocity filter); the lag is corrected"
    assert (mended.dq[:, 1] == log.dq[:, 1]).all()
    assert np.abs(mended.dq[100:-100] - dq[100:-100, None]).max() < 0.03 * np.abs(dq).max()


def test_a_velocity_of_another_clock_is_said_and_left_as_it_is() -> None:
    slow = 0.6 * np.sin(0.8 * T)
    late = log_with(0.48 * np.cos(0.8 * (T - 0.195)), slow)
    found = estimate_log(late, AuditSettings()).interaction
    (caution,) = [one for one in found.warnings if one.code.startswith("dq_")]
    assert caution.code == "dq_other_clock"
    assert sentence_of(caution).startswith("joint 1: dq lags q by 1")
    assert (found.dq == late.dq).all()


def test_a_joint_that_stands_still_is_not_accused_of_its_vibration() -> None:
    q, dq = 0.01 * motion()[0], 0.01 * motion()[1]
    log = log_with(np.interp(T - 0.006, T, dq), q)
    assert velocity.on_time(log, coarse_log(log)) == (log, ())


@pytest.mark.parametrize(("rate_hz", "samples"), [(40.0, 100), (50.0 + 1e-9, 100), (1000.0, 15)])
def test_what_cannot_be_filtered_is_left_alone(rate_hz: float, samples: int) -> None:
    dq = np.random.default_rng(0).normal(size=samples)
    assert velocity.filter_velocity(dq, rate_hz=rate_hz, cutoff_hz=20) is dq


@given(st.integers(0, 1000), st.integers(16, 3000), st.floats(51, 10_000))
def test_the_filter_is_that_of_scipy(seed: int, samples: int, rate_hz: float) -> None:
    dq = np.random.default_rng(seed).normal(size=samples).cumsum()
    expected = sosfiltfilt(butter(2, 20.0, fs=rate_hz, output="sos"), dq)
    filtered = velocity.filter_velocity(dq, rate_hz=rate_hz, cutoff_hz=20.0)
    np.testing.assert_allclose(filtered, expected, atol=1e-9 * np.abs(dq).max())


# The mean of two velocities: the derivative of a coarse position and a noisy tachometer.

GRID_S = 1.0 / 400.0
GRID: Float = np.arange(40000, dtype=np.float64) * GRID_S
TRUE: Float = np.sin(2 * np.pi * 0.5 * GRID)


def readings(q_noise: float, dq_noise: float) -> tuple[Float, Float]:
    """Noise of the position's derivative and of a tachometer, up to 80 Hz each."""
    rng = np.random.default_rng(0)
    hertz = np.fft.rfftfreq(len(GRID), GRID_S)
    white = [np.fft.rfft(rng.standard_normal(len(GRID))) * (hertz < 80.0) for _ in range(2)]
    slope = np.fft.irfft(2j * np.pi * hertz * white[0])
    return TRUE + q_noise * slope, TRUE + dq_noise * np.fft.irfft(white[1])


def test_the_crossover_is_where_both_are_equally_noisy_and_none_is_below_the_frequencies_of_motions() -> None:
    assert velocity.crossover_of(*readings(1e-5, 2 * np.pi * 20.0 * 1e-5), GRID_S) == pytest.approx(20.0, rel=0.1)
    assert velocity.crossover_of(*readings(1e-3, 2 * np.pi * 1e-3), GRID_S) == 0.0
    assert velocity.crossover_of(np.zeros(50), np.ones(50), GRID_S) == 0.0


@pytest.mark.parametrize("share", [1.0, 0.1])
def test_noise_that_comes_and_goes_is_found_as_what_two_velocities_do_not_have_in_common(share: float) -> None:
    """The median of second differences shows a fifth of the noise that is there a tenth of the time."""
    rng, hertz = np.random.default_rng(1), np.fft.rfftfreq(len(GRID), GRID_S)
    there = np.where(rng.random((2, len(GRID))) < share, 1.0 / np.sqrt(share), 0.0)
    noise = np.array([[1e-5], [1e-3]]) * there * rng.standard_normal(there.shape)
    white = np.fft.rfft(noise) * (hertz < 80.0)
    slope, logged = (TRUE + np.fft.irfft(one) for one in (2j * np.pi * hertz * white[0], white[1]))
    found = velocity.noise_of_both(slope, logged, np.ones(len(GRID), bool), GRID_S, 0.0)
    assert_allclose(found, np.array([1e-5, 1e-3]) * np.sqrt(2.0 * GRID_S), rtol=0.1)


def test_where_the_position_cannot_be_trusted_it_is_the_logged_one() -> None:
    slope, logged = readings(1e-5, 1e-3)
    hole = (GRID > 40.0) & (GRID < 45.0)
    wild = np.where(hole, 1e3, slope)
    both = velocity.complementary_mean(wild, logged, ~hole, GRID_S, 20.0)
    inside = (GRID > 41.0) & (GRID < 44.0)
    assert both[inside] == pytest.approx(logged[inside])
    assert np.abs(both - TRUE).max() < 0.01


def test_a_position_is_as_good_as_the_velocity_and_follows_itself_through_a_hole() -> None:
    rng, q = np.random.default_rng(3), -np.cos(np.pi * GRID) / np.pi
    valid = (GRID < 40.0) | (GRID > 41.0)
    dq, ddq = np.where(valid, TRUE + 1e-3 * rng.standard_normal(len(GRID)), 0.0), np.pi * np.cos(np.pi * GRID)
    error = velocity.position_of(q + 1e-4 * rng.standard_normal(len(GRID)), dq, ddq, valid, GRID_S, 0.0) - q
    assert np.std(error[valid]) < 3e-5
    assert np.abs(error).max() < 4e-4
