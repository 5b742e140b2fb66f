"""One filter for torque and motion, on real stamps; directions that are certain; velocities from the quieter source."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.prepare import fresh_samples, holes, low_pass_for, prepare
from friction_audit.effects.joint_data import JointData
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log
from friction_audit.preprocessing.velocity import lag_of
from friction_audit.simulation import BenchSettings, simulate


@cache
def bench() -> Estimate:
    return estimate_log(simulate(BenchSettings(duration_s=20.0), 0).log, AuditSettings())


def prepared(estimate: Estimate) -> JointData:
    (data,) = prepare(estimate.interaction, estimate.cycles, estimate.log)
    return data


def test_a_slow_sine_passes_with_its_derivative() -> None:
    t = np.arange(0, 5, 1e-3)
    low_pass = low_pass_for(t)
    slow, slope = low_pass.with_slope(t, np.sin(4 * np.pi * t))
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    assert np.abs(slow - np.sin(4 * np.pi * low_pass.t))[inside].max() < 1e-3
    assert np.abs(slope - 4 * np.pi * np.cos(4 * np.pi * low_pass.t))[inside].max() < 2e-2


def test_a_position_bends_over_lost_samples() -> None:
    t = np.delete(np.arange(0, 5, 1e-3), np.arange(2000, 2009))
    low_pass = low_pass_for(t)
    _, slope = low_pass.with_slope(t, 5.0 * t**2)
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    # A straight line over 10 ms would be off by 0.125 mrad, and its slope by 14 mrad/s.
    assert np.abs(slope - 10.0 * low_pass.t)[inside].max() < 1e-3


@pytest.mark.parametrize(("frequency", "gain"), [(40.0, 1.0), (80.0, 0.5), (130.0, 0.0)])
def test_corner(frequency: float, gain: float) -> None:
    t = np.arange(0, 5, 2.5e-4)
    low_pass = low_pass_for(t)
    inside = (low_pass.t > 0.2) & (low_pass.t < 4.7)
    passed = low_pass.of(t, np.sin(2 * np.pi * frequency * t + 0.7))[inside]
    assert np.sqrt(2 * np.mean(passed**2)) == pytest.approx(gain, abs=0.01)


@pytest.mark.parametrize(
    ("rate", "grid", "corner"), [(50.0, 50.0, 12.5), (300.0, 300.0, 75.0), (500.0, 400.0, 80.0), (1000.0, 400.0, 80.0)]
)
def test_grid_is_not_faster_than_the_log(rate: float, grid: float, corner: float) -> None:
    t = np.arange(0, 5, 1 / rate)
    low_pass = low_pass_for(t)
    assert 1 / (low_pass.t[1] - low_pass.t[0]) == pytest.approx(grid)
    assert low_pass.corner_hz == pytest.approx(corner)
    assert (low_pass.t[0], low_pass.t[-1]) == pytest.approx((0.0, t[-1]), abs=1 / grid)
    assert low_pass.of(t, np.ones(len(t))) == pytest.approx(1.0)


def test_an_impulse_comes_out_where_it_went_in() -> None:
    t = np.arange(0, 2, 1e-3)
    low_pass = low_pass_for(t)
    passed = low_pass.of(t, (t == 1.0).astype(float))
    assert passed @ low_pass.t / passed.sum() == pytest.approx(1.0, abs=1e-6)
    assert np.argmax(passed) == 400


def test_holes_are_those_that_motion_bends_in() -> None:
    t = np.delete(np.arange(2000) * 1e-3, [*range(500, 515), *range(900, 925)])
    (hole,) = holes(t)
    assert t[hole] == pytest.approx(0.899)


def test_a_stale_sample_of_a_moving_joint_is_no_news_and_that_of_a_resting_one_is() -> None:
    log = bench().log
    moving = int(np.argmax(np.abs(log.dq[:, 0])))
    still = replace(log, q=np.full_like(log.q, 0.3), dq=np.zeros_like(log.dq))
    q, dq = log.q.copy(), log.dq.copy()
    q[moving + 1], dq[moving + 1] = q[moving], dq[moving]
    assert not fresh_samples(replace(log, q=q, dq=dq))[moving + 1]
    assert fresh_samples(still).all()


def test_a_hole_and_the_ends_are_not_valid() -> None:
    log = bench().log
    kept = (log.t < 10.0) | (log.t > 10.3)
    channels: dict[str, Any] = {name: channel[kept] for name, channel in log.channels().items()}
    data = prepared(estimate_log(replace(log, t=log.t[kept], **channels), AuditSettings()))
    reach = low_pass_for(log.t).reach_s
    invalid = data.t[~data.valid & (data.t > 9.0) & (data.t < 11.0)]
    assert (invalid[0], invalid[-1]) == pytest.approx((10.0 - reach, 10.3 + reach), abs=0.006)
    assert not data.valid[0]
    assert not data.valid[-1]
    assert data.valid.mean() > 0.97


def test_velocity_comes_from_the_quieter_of_position_and_velocity() -> None:
    estimate = bench()
    rng = np.random.default_rng(0)
    loud = {
        name: replace(
            estimate.log, **{name: getattr(estimate.log, name) + sigma * rng.standard_normal(estimate.log.q.shape)}
        )
        for name, sigma in (("q", 1e-3), ("dq", 0.2))
    }
    source = {name: prepared(replace(estimate, log=log)).derived_from for name, log in loud.items()}
    assert source == {"q": "dq", "dq": "q"}


def test_cycles_are_those_of_the_segmentation() -> None:
    estimate = bench()
    data = prepared(estimate)
    for number, (start, stop) in enumerate(zip(estimate.cycles.start_s, estimate.cycles.stop_s, strict=True)):
        inside = data.t[data.cycle == number]
        assert start <= inside[0]
        assert inside[-1] < stop


def test_a_quick_reversal_is_certain_and_a_rest_is_not() -> None:
    data = prepared(bench())
    speed = np.abs(data.dq)
    rests = (speed < data.dead_speed_rad_s) & data.valid
    # Bench strokes end at rest: what is not moving lies below the dead speed, and most of what is below is not moving.
    assert np.all(speed[~data.moving] <= data.dead_speed_rad_s)
    assert np.mean(data.moving[rests]) < 0.5


@pytest.mark.parametrize("corner_hz", [30.0, 2.0])
def test_a_filtered_difference_gives_way_to_the_position(corner_hz: float) -> None:
    estimate = bench()
    log = estimate.log
    step = float(np.median(np.diff(log.t)))
    pole = np.exp(-2 * np.pi * corner_hz * step)
    slope = np.diff(log.q[:, 0], prepend=log.q[0, 0]) / step
    late = lfilter([1 - pole], [1, -pole], slope)[:, None]
    assert prepared(replace(estimate, log=replace(log, dq=late))).derived_from == "q"


def test_a_late_velocity_that_stays_is_put_on_time() -> None:
    """The position is too coarse for a derivative, so the velocity is kept and its lag taken out."""
    estimate = bench()
    log = estimate.log
    t, coarse = log.t, np.round(log.q / 2e-3) * 2e-3
    late = np.interp(t - 0.004, t, log.dq[:, 0])[:, None]
    data = prepared(replace(estimate, log=replace(log, q=coarse, dq=late)))
    true = prepared(replace(estimate, log=replace(log, q=coarse)))
    assert data.derived_from == true.derived_from == "dq"
    reference = np.interp(data.t, true.t, true.dq)
    bend = np.gradient(reference, data.t)
    left, _ = lag_of(*(one[data.valid, None] for one in (data.dq, reference, bend, bend)))
    assert abs(left[0]) < 4e-4
