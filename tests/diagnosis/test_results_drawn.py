"""What a diagnosis computes for its figures: an effect's own axis, and the residual over contact events."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.diagnosis.profiles import own_axis
from friction_audit.diagnosis.result import NamedEffect
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.pipeline import AuditSettings, diagnose_log
from friction_audit.simulation import BenchSettings, simulate
from tests.reporting.diagnosis_by_hand import STRIBECK, coefficient, traces

TRACES = traces(4)
TORQUE = np.linspace(-0.1, 0.2, len(TRACES.t))


def effect(name: str, **parameters: float) -> NamedEffect:
    numbers = {key: coefficient(value, 0.0) for key, value in parameters.items()}
    return replace(STRIBECK, name=name, parameters=numbers, torque=TORQUE)


def test_a_curve_over_the_joint_s_own_motion_needs_no_axis_of_its_own() -> None:
    assert own_axis(effect("stribeck", stribeck_excess_nm=0.1), TRACES) is None
    assert own_axis(effect("gravity_error", gravity_error_source=0.0), TRACES) is None


def test_waves_are_laid_over_each_other() -> None:
    own = own_axis(effect("torque_ripple", ripple_order=100.0), replace(TRACES, q=TRACES.q * 0.0 + 0.0125 * np.pi))
    assert own is not None
    assert own.label == "Position within a wave [waves]"
    assert own.values == pytest.approx(0.625)


@pytest.mark.parametrize(
    "one",
    [
        effect("inertial_coupling", coupling_source=3.0),
        effect("torque_crosstalk", crosstalk_after=0.1),
        effect("gravity_error", gravity_error_source=-1.0),
    ],
    ids=lambda one: one.name,
)
def test_an_effect_of_other_joints_is_drawn_along_its_torque(one: NamedEffect) -> None:
    own = own_axis(one, TRACES)
    assert own is not None
    assert own.label == f"Fitted torque of {one.name} [N m]"
    assert own.values is TORQUE


def test_ringing_is_drawn_along_its_torque_and_its_means_are_those_of_the_samples() -> None:
    rows = np.arange(4800)
    motion = traces(1600)
    along = motion.along | {"speed": rows % 400 / 400.0}
    ringing = np.sin(0.77 * rows)
    motion = replace(motion, dq=np.where(rows % 2, 1.0, -1.0), along=along, after=motion.measured - 0.5)
    own = own_axis(replace(STRIBECK, torque=ringing), motion)
    assert own is not None
    assert own.values is ringing
    assert own.after.edges == pytest.approx(np.linspace(ringing.min(), ringing.max(), 13))
    assert own.after.forwards == pytest.approx(0.5)
    assert own.curve.backwards == pytest.approx(0.5 + own.curve.centre, abs=0.05)


LENGTH_S = 0.3


@pytest.fixture(scope="module")
def pushed() -> Any:
    """Return two pushes (moment [s], torque [N m]) while the joint moves, and the diagnosis of the log with them."""
    log = simulate(BenchSettings(duration_s=40.0), 3).log
    slow = log.t[np.abs(log.dq[:, 0]) < 0.1]
    pushes = []
    for after_s, size in ((12.0, 2.0), (25.0, -3.0)):
        starts = np.append(after_s, slow[slow > after_s])
        start = float(starts[np.flatnonzero(np.diff(starts) > 1.5 * LENGTH_S)[0]]) + 0.25 * LENGTH_S
        pushes.append((start, size))
    torque = np.array(log.tau_interaction)
    for start, size in pushes:
        inside = (log.t >= start) & (log.t < start + LENGTH_S)
        torque[inside, 0] += size * np.sin(np.pi * (log.t[inside] - start) / LENGTH_S)
    settings = DiagnosisSettings(candidates=("contact_event", "stribeck"))
    found = diagnose_log(replace(log, tau_interaction=torque), AuditSettings(), settings)
    return tuple(pushes), found.discrepancy.joints[0]


def test_each_contact_is_where_it_was_and_as_large_as_it_was(pushed: Any) -> None:
    pushes, joint = pushed
    trace = joint.contacts
    assert all(
        low < start + 0.5 * LENGTH_S < high for (start, _), (low, high) in zip(pushes, trace.spans_s, strict=True)
    )
    for start, size in pushes:
        near = trace.residual_nm[np.abs(trace.t - start - 0.5 * LENGTH_S) < 0.02]
        assert float(np.nanmean(near)) == pytest.approx(size, rel=0.1)
    apart = np.all([np.abs(trace.t - start - 0.5 * LENGTH_S) > 0.5 for start, _ in pushes], axis=0)
    assert float(np.nanstd(trace.residual_nm[apart])) < 0.05
