"""Of a long recording, parts that are spread over it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit import estimate_log, simulate_log
from friction_audit.diagnosis.prepare import BRIDGE_S, FORGOTTEN_S, parts_of, spread_parts
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.dynamics.motion import RigidBody
from friction_audit.effects.joint_data import duration
from friction_audit.pipeline import diagnosis_subjects
from tests.effects.joint_data_by_hand import STEP_S, two_sines

WHOLE = two_sines(400.0)


def test_a_recording_that_is_hardly_longer_is_diagnosed_whole() -> None:
    assert [parts_of(seconds, 300.0) for seconds in (120.0, 310.0, 311.0, 3600.0)] == [1, 1, 5, 5]
    assert spread_parts(WHOLE, 395.0, {}) is WHOLE


def test_parts_are_those_of_the_recording_from_its_begin_to_its_end() -> None:
    parts = spread_parts(WHOLE, 120.0, {})
    assert (parts.t[0], parts.t[-1]) == (WHOLE.t[0], WHOLE.t[-1])
    assert len(parts.t) * STEP_S == pytest.approx(120.0 + BRIDGE_S)
    place = np.searchsorted(WHOLE.t, parts.t[parts.valid] - 0.5 * STEP_S)
    for name in ("t", "q", "dq", "ddq", "torque", "temperature", "others_dq", "others_ddq", "others_torque"):
        np.testing.assert_array_equal(getattr(parts, name)[parts.valid], getattr(WHOLE, name)[place], err_msg=name)
    assert np.count_nonzero(parts.valid) * STEP_S == pytest.approx(120.0 - FORGOTTEN_S)
    kept = np.unique(parts.cycle[parts.cycle >= 0])
    for cycle in kept:
        assert np.count_nonzero(parts.cycle == cycle) == np.count_nonzero(WHOLE.cycle == cycle)
    assert 0.25 * len(np.unique(WHOLE.cycle)) < len(kept) < 0.3 * len(np.unique(WHOLE.cycle))


def test_between_parts_the_joint_moves_on_without_a_jump() -> None:
    parts = spread_parts(WHOLE, 120.0, {})
    assert np.abs(np.diff(parts.q) / STEP_S - 0.5 * (parts.dq[1:] + parts.dq[:-1])).max() < 1e-3
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
    estimate = estimate_log(simulate_log("joint", duration_s=60.0).log)
    (subject,) = diagnosis_subjects(estimate, DiagnosisSettings(at_most_s=20.0))
    assert duration(subject.data) == pytest.approx(40.0, abs=0.01)
    assert len(subject.data.t) * subject.data.step_s == pytest.approx(20.0 + BRIDGE_S, abs=0.1)
    assert "only 20 s of 60 s are diagnosed, in parts from" in subject.findings[0].message
