"""Faults put into clean data are found, with their size."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.data_audit import DataFinding, audit_clock, audit_data
from friction_audit.diagnosis.prepare import prepare
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Finding, Float, JointLog
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.simulation import BenchSettings, simulate

Audited = tuple[JointLog, Interaction, JointData]


def prepared(log: JointLog, settings: AuditSettings = AuditSettings()) -> Audited:  # noqa: B008 - frozen
    estimate = estimate_log(log, settings)
    (data,) = prepare(estimate.interaction, estimate.cycles, log)
    return log, estimate.interaction, data


@pytest.fixture(scope="module")
def clean() -> Audited:
    return prepared(simulate(BenchSettings(duration_s=30.0), 0).log)


def found(audited: Audited, data: JointData | None = None) -> dict[str, DataFinding]:
    log, interaction, own = audited
    return {one.code: one for one in audit_data(log, interaction, data or own, audit_clock(log))}


@pytest.mark.parametrize(
    ("change", "code", "size"),
    [
        (lambda data: np.interp(data.t - 0.03, data.t, data.dq), "dq_delay", 0.03),
        (lambda data: 1.2 * data.dq, "dq_scale", 0.2),
        (lambda data: -data.dq, "dq_scale", 2.0),
        (lambda data: 0.0 * data.dq, "dq_against_q", 0.0),
    ],
    ids=["late", "scaled", "turned", "zero while the position moves"],
)
def test_a_wrong_velocity_is_a_fault_with_its_size(
    clean: Audited, change: Callable[[JointData], Float], code: str, size: float
) -> None:
    measured = found(clean, replace(clean[2], logged_dq=change(clean[2])))
    assert {one.code for one in measured.values() if one.verdict == "fault"} == {code}
    assert measured[code].value == pytest.approx(size, rel=0.1)


def test_stamps_of_batches_are_a_fault(clean: Audited) -> None:
    log, interaction, data = clean
    batched = replace(log.source, findings=(Finding(code="batched_stamps", message="", amount=9.0),))
    measured = found((replace(log, source=batched), interaction, data))
    assert [one.code for one in measured.values() if one.verdict == "fault"] == ["batched_stamps"]


def test_a_motion_that_gains_energy_has_one_score_in_estimate_and_diagnosis() -> None:
    log = simulate(BenchSettings(duration_s=30.0), 0).log
    turned = replace(log, tau_J=log.tau_interaction, tau_interaction=None)  # the hand's row turns it
    audited = prepared(turned, AuditSettings(torque=TorqueSettings(drive="hand")))
    gaining, (evidence,) = found(audited)["power"], audited[1].choice.sign_evidence
    assert (gaining.verdict, evidence.verdict) == ("fault", "falls")
    assert gaining.value == evidence.normal_score < -5.0
    assert "sign_contradicts_drive" in [one.code for one in audited[1].warnings]


def test_recorder_and_sensor_are_measured(clean: Audited) -> None:
    measured = found(clean)
    assert measured["stale"].value == pytest.approx(0.056, abs=0.01)
    assert measured["torque_step"].value == pytest.approx(0.0357, rel=0.01)
    assert measured["holes"].value == 0


def test_one_speed_is_a_limit_and_no_fault(clean: Audited) -> None:
    data = clean[2]
    assert found(clean, replace(data, dq=0.5 * np.sign(data.dq)))["speed_spread"].verdict == "limit"


def test_gravity_of_several_joints_in_the_torque_is_a_limit(clean: Audited) -> None:
    log, interaction, data = clean
    measured = found((log, replace(interaction, posture=log.q.repeat(2, axis=1)), data))["gravity"]
    assert (found(clean)["gravity"].verdict, measured.verdict, measured.value) == ("fine", "limit", 1.0)


def test_velocities_of_a_joint_at_rest_are_noise_and_no_fault(clean: Audited) -> None:
    data = clean[2]
    rng = np.random.default_rng(0)
    q, dq = 1e-5 * rng.standard_normal((2, len(data.t)))
    measured = found(clean, replace(data, q=q, dq=dq, logged_dq=dq, cycle=np.full(len(data.t), -1)))
    assert "fault" not in {one.verdict for one in measured.values()}
    assert "dq_noise" in measured
