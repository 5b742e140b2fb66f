"""Samples of a regression: the filter by hand, what counts, and how high the corner may stand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.diagnosis.samples import LOWEST_CORNER_HZ, QUIET_SHARE, corner_for, make_samples
from friction_audit.effects.joint_data import CORNER_HZ
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import LowPass, filtered
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.started_and_stopped import COULOMB_NM, EXCESS_NM, RISE_NM_PER_S, started_and_stopped

DATA = moved_joint(duration_s=20.0)


def filtered_by_hand(signal: Float, kernel: Float, every: int) -> Float:
    half = len(kernel) // 2
    held = np.concatenate([np.full(half, signal[0]), signal, np.full(half, signal[-1])])
    return np.convolve(held, kernel, mode="valid")[::every]


@settings(deadline=None)
@given(n=st.integers(1, 60), half=st.integers(0, 12), every=st.integers(1, 7), seed=st.integers(0, 1000))
def test_every_sample_is_the_filter_about_its_sample(n: int, half: int, every: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kernel = rng.random(half + 1)
    kernel = np.concatenate([kernel[:0:-1], kernel])
    columns = rng.standard_normal((n, 2))
    found = filtered(np.ascontiguousarray(columns.T), kernel, np.arange(0, n, every))
    assert found.shape == (2, (n - 1) // every + 1)
    for k in range(2):
        assert found[k] == pytest.approx(filtered_by_hand(columns[:, k], kernel, every), abs=1e-12)


@pytest.mark.parametrize(("frequency", "gain"), [(4.0, 1.0), (13.0, 1.0), (25.0, 0.5), (45.0, 0.0)])
def test_a_sine_passes_without_delay_up_to_the_corner(frequency: float, gain: float) -> None:
    samples = make_samples(DATA)
    sine = np.sin(2 * np.pi * frequency * DATA.t)
    assert samples.of(sine) == pytest.approx(gain * np.sin(2 * np.pi * frequency * samples.t), abs=0.01)


def test_torque_and_columns_go_the_same_way() -> None:
    samples = make_samples(DATA)
    assert samples.y == pytest.approx(samples.of(DATA.torque))
    assert samples.of(np.column_stack([DATA.torque, DATA.dq]))[:, 1] == pytest.approx(samples.of(DATA.dq))
    assert samples.every == 4
    assert np.diff(samples.t).min() == pytest.approx(0.01)
    assert np.array_equal(samples.cycle, DATA.cycle[samples.place * 4])


def test_no_sample_sees_a_sample_that_is_not_valid() -> None:
    valid = DATA.valid.copy()
    valid[4001:4003] = False
    samples = make_samples(replace(DATA, valid=valid))
    half_s = len(samples.kernel) // 2 / 400
    seen = samples.t[:, None] - DATA.t[~valid]
    assert np.abs(seen).min() > half_s
    assert np.diff(samples.t).max() == pytest.approx(2 * half_s + 0.01, abs=0.011)


def test_a_short_doubt_about_the_direction_costs_only_the_samples_that_weigh_it() -> None:
    moving = DATA.moving.copy()
    moving[4000:4040] = False
    samples = make_samples(replace(DATA, moving=moving))
    inside = (samples.t >= DATA.t[4000]) & (samples.t < DATA.t[4040])
    assert not inside.any()
    lost = len(make_samples(DATA).t) - len(samples.t)
    assert 10 < lost < 10 + 2 * len(samples.kernel) // 2 / samples.every


def test_a_slow_grid_keeps_its_own_rate_and_a_quarter_as_corner() -> None:
    slow = DATA.t[::8]
    thin = {name: getattr(DATA, name)[::8] for name in ("q", "dq", "ddq", "torque", "cycle", "moving", "valid")}
    samples = make_samples(replace(DATA, t=slow, **thin))
    assert (samples.every, samples.corner_hz) == (1, 12.5)


@pytest.mark.parametrize("crossing_hz", [5.0, 10.0, 16.0, 60.0])
def test_the_corner_is_where_the_noise_of_inertia_is_half_of_that_of_the_torque(crossing_hz: float) -> None:
    rng = np.random.default_rng(0)
    t = np.arange(0, 60, 1e-3)
    low_pass = LowPass.for_stamps(t)
    inertia, torque_noise = 0.2, 0.05
    # J (2 pi f)^2 sigma_q = sigma_torque / 2 at the crossing, both white at the same rate.
    position_noise = QUIET_SHARE * torque_noise / (inertia * (2 * np.pi * crossing_hz) ** 2)
    torque = low_pass.of(t, torque_noise * rng.standard_normal(len(t)))
    q, dq = low_pass.with_slope(t, position_noise * rng.standard_normal(len(t)))
    ddq = np.gradient(dq, low_pass.t)
    noisy = replace(DATA, t=low_pass.t, q=q, dq=dq, ddq=ddq, torque=torque, derived_from="q")
    expected = np.clip(crossing_hz, LOWEST_CORNER_HZ, CORNER_HZ)
    # The difference quotient passes only three quarters at 80 Hz, so that the acceleration seems quieter than it is.
    assert corner_for(noisy, inertia) == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("removed", [0.0, 1.0], ids=["a joint of its own", "links that a model took away"])
def test_the_corner_of_a_velocity_that_was_logged(removed: float) -> None:
    rng = np.random.default_rng(1)
    t = np.arange(0, 60, 1e-3)
    low_pass = LowPass.for_stamps(t)
    # J 2 pi f sigma_dq = sigma_torque / 2 at 15 Hz.
    torque = low_pass.of(t, 0.05 * rng.standard_normal(len(t)))
    dq, ddq = low_pass.with_slope(t, QUIET_SHARE * 0.05 / (0.2 * 2 * np.pi * 15.0) * rng.standard_normal(len(t)))
    links = removed * 0.2 * ddq
    noisy = replace(DATA, t=low_pass.t, dq=dq, ddq=ddq, torque=torque - links, load=links, derived_from="dq")
    assert corner_for(noisy, 0.2 * (1.0 - removed)) == pytest.approx(15.0, rel=0.1)
    assert corner_for(DATA, 0.0) == CORNER_HZ


def test_a_joint_that_breaks_away_has_a_sample_for_it_beside_those_of_its_motion() -> None:
    data = started_and_stopped()
    samples = make_samples(data)
    broke = samples.breakaway
    assert broke.sum() == 20
    assert samples.t[broke] % 1.0 == pytest.approx(0.5, abs=0.011)
    assert np.abs(samples.y[~broke]) == pytest.approx(COULOMB_NM, abs=0.01)
    assert samples.of(np.sign(data.dq))[broke] == pytest.approx(samples.weight[broke] * np.sign(samples.y[broke]))
    early_nm = RISE_NM_PER_S * 0.015  # with stiction the onset is told too early
    excess = np.abs(samples.y / samples.weight)[broke] - COULOMB_NM
    assert np.all((excess > EXCESS_NM - early_nm) & (excess <= EXCESS_NM + 1e-9))
    assert samples.of(data.ddq)[broke] == pytest.approx(0.0)


def test_a_sample_of_break_away_is_as_noisy_as_the_others() -> None:
    quiet, noisy = (make_samples(started_and_stopped(noise, starts=400)) for noise in (0.0, 0.01))
    left = noisy.y - quiet.y
    broke = noisy.weight < 1.0
    assert np.std(left[broke]) == pytest.approx(np.std(left[~broke]), rel=0.15)


def test_a_break_away_next_to_a_hole_or_outside_of_cycles_is_no_row() -> None:
    data = started_and_stopped()
    holed, outside = data.valid.copy(), data.cycle.copy()
    holed[4 * 400 + 180] = False  # in the standstill before the fifth start
    outside[10 * 400 : 11 * 400] = -1
    t = make_samples(replace(data, valid=holed, cycle=outside)).t
    assert not np.any((np.abs(t - 4.5) < 0.02) | (np.abs(t - 10.5) < 0.02))
    assert np.any(np.abs(t - 5.5) < 0.02)
