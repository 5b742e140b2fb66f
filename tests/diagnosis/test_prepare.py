"""One filter for torque and motion, on real stamps; directions that are certain; velocities from the quieter source."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit import simulate_log
from friction_audit.diagnosis.prepare import BRIDGE_S, FORGOTTEN_S, certain_direction, parts_of, prepare, spread_parts
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.dynamics.motion import RigidBody
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.pipeline import AuditSettings, Estimate, diagnosis_subjects, estimate_log
from friction_audit.preprocessing.even_grid import LowPass
from friction_audit.simulation import BenchSettings, simulate
from tests.effects.joint_data_by_hand import two_sines


@cache
def bench() -> Estimate:
    return estimate_log(simulate(BenchSettings(duration_s=20.0), 0).log, AuditSettings())


def prepared(estimate: Estimate) -> JointData:
    (data,) = prepare(estimate.interaction, estimate.cycles, estimate.log)
    return data


def test_a_hole_and_the_ends_are_not_valid() -> None:
    log = bench().log
    kept = (log.t < 10.0) | (log.t > 10.3)
    channels: dict[str, Any] = {name: channel[kept] for name, channel in log.channels().items()}
    data = prepared(estimate_log(replace(log, t=log.t[kept], **channels), AuditSettings()))
    low_pass = LowPass.for_stamps(log.t)
    reach = low_pass.t[0] - low_pass.fine[0]
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


@pytest.mark.parametrize("corner_hz", [30.0, 2.0])
def test_a_filtered_difference_gives_way_to_the_position(corner_hz: float) -> None:
    estimate = bench()
    log = estimate.log
    step = float(np.median(np.diff(log.t)))
    pole = np.exp(-2 * np.pi * corner_hz * step)
    slope = np.diff(log.q[:, 0], prepend=log.q[0, 0]) / step
    late = lfilter([1 - pole], [1, -pole], slope)[:, None]
    assert prepared(replace(estimate, log=replace(log, dq=late))).derived_from == "q"


STEP_S = 0.0025
DEAD = 0.003
ACCELERATION = 2.0
EVERY_S = 0.5


def velocity(dwell_s: float, jerk: float = 0.0) -> Float:
    """Strokes at constant acceleration, or growing, a rest of so long after each, through a filter of 12.5 ms."""
    t = np.arange(0.0, 10.0, STEP_S / 10)
    since = (t + 0.0003) % EVERY_S - EVERY_S / 2
    beyond = np.sign(since) * np.maximum(np.abs(since) - dwell_s / 2, 0.0)
    sharp = (ACCELERATION * beyond + jerk * beyond**2) * (-1.0) ** np.floor((t + 0.0003) / EVERY_S)
    window = np.hanning(52)[1:-1]
    smooth = np.convolve(sharp, window / window.sum(), mode="same")
    return np.asarray(smooth[::10])


def reversals(dq: Float) -> list[int]:
    return [k for k in np.flatnonzero(dq[1:] * dq[:-1] < 0).tolist() if abs(dq[k]) < ACCELERATION * EVERY_S / 8]


@pytest.mark.parametrize("jerk", [0.0, 5.0])
def test_a_reversal_without_a_rest_is_certain(jerk: float) -> None:
    dq = velocity(0.0, jerk)
    moving = certain_direction(dq, DEAD, STEP_S)
    inner = [k for k in reversals(dq) if 20 < k < len(dq) - 20]
    assert len(inner) > 15
    assert all(moving[k - 1 : k + 3].all() for k in inner)


@pytest.mark.parametrize("dwell_s", [0.002, 0.004, 0.008])
def test_a_short_rest_takes_the_certainty(dwell_s: float) -> None:
    dq = velocity(dwell_s)
    moving = certain_direction(dq, DEAD, STEP_S)
    assert not any(moving[k] and moving[k + 1] for k in reversals(dq))


def test_a_turn_back_right_after_a_reversal_leaves_doubt() -> None:
    strokes = np.repeat([1.0, -1.0, 1.0], [60, 6, 60]) * 0.1
    moving = certain_direction(strokes, DEAD, STEP_S)
    assert not moving[[59, 60, 65, 66]].any()
    assert moving[:59].all()
    assert not certain_direction(0.04 * DEAD * strokes, DEAD, STEP_S).any()


# Of a long recording, parts that are spread over it.

WHOLE = two_sines(400.0)


def test_a_recording_that_is_hardly_longer_is_diagnosed_whole() -> None:
    assert [parts_of(seconds, 300.0) for seconds in (120.0, 310.0, 311.0, 3600.0)] == [1, 1, 5, 5]
    assert spread_parts(WHOLE, 395.0, {}) is WHOLE


def test_parts_are_those_of_the_recording_from_its_begin_to_its_end() -> None:
    parts = spread_parts(WHOLE, 120.0, {})
    assert (parts.t[0], parts.t[-1]) == (WHOLE.t[0], WHOLE.t[-1])
    assert len(parts.t) * WHOLE.step_s == pytest.approx(120.0 + BRIDGE_S)
    place = np.searchsorted(WHOLE.t, parts.t[parts.valid] - 0.5 * WHOLE.step_s)
    pairs = [(getattr(parts, name), getattr(WHOLE, name)) for name in ("t", "q", "dq", "ddq", "torque", "temperature")]
    pairs += [(getattr(parts.others, name), getattr(WHOLE.others, name)) for name in ("q", "dq", "ddq", "sensed")]
    for own, all_of in pairs:
        np.testing.assert_array_equal(own[parts.valid], all_of[place])
    assert np.count_nonzero(parts.valid) * WHOLE.step_s == pytest.approx(120.0 - FORGOTTEN_S)
    kept = np.unique(parts.cycle[parts.cycle >= 0])
    for cycle in kept:
        assert np.count_nonzero(parts.cycle == cycle) == np.count_nonzero(WHOLE.cycle == cycle)
    assert 0.25 * len(np.unique(WHOLE.cycle)) < len(kept) < 0.3 * len(np.unique(WHOLE.cycle))


def test_between_parts_the_joint_moves_on_without_a_jump() -> None:
    parts = spread_parts(WHOLE, 120.0, {})
    assert np.abs(np.diff(parts.q) / WHOLE.step_s - 0.5 * (parts.dq[1:] + parts.dq[:-1])).max() < 1e-3
    assert np.abs(np.diff(parts.dq)).max() < 2.0 * np.abs(np.diff(WHOLE.dq)).max()
    assert np.all(np.diff(parts.t) > 0.0)


def test_the_model_of_the_arm_stays_at_its_times() -> None:
    t = WHOLE.t[::2]
    body = RigidBody(
        t=t, links=(1,), weight=np.sin(t)[:, None, None] * np.ones((1, 4)), tilt=np.zeros((len(t), 2)),
        inertial=np.cos(t), tip=None,
    )  # fmt: skip
    parts: Any = spread_parts(replace(WHOLE, rigid=body), 120.0, {})
    np.testing.assert_array_equal(parts.rigid.t[: 60 * 100], parts.t[::2][: 60 * 100])
    fine = parts.rigid.on(parts.t)
    # As far from other samples as a filter reaches.
    far = np.convolve(parts.valid, np.ones(41), mode="same") == 41.0
    np.testing.assert_allclose(fine.inertial[far], np.cos(parts.t[far]), atol=1e-6)


def test_of_a_much_longer_log_a_window_of_twice_the_length_is_prepared() -> None:
    estimate = estimate_log(simulate_log("joint", duration_s=60.0).log, AuditSettings())
    (subject,) = diagnosis_subjects(estimate, DiagnosisSettings(at_most_s=20.0))
    assert float(np.ptp(subject.data.t)) == pytest.approx(40.0, abs=0.01)
    assert len(subject.data.t) * subject.data.step_s == pytest.approx(20.0 + BRIDGE_S, abs=0.1)
    assert (subject.findings[0].code, subject.findings[0].bound) == ("part", 20.0)
