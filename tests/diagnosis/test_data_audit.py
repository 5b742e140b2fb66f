"""Faults put into clean data are found, with their size."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.data_audit import DataFinding, audit_clock, audit_data, faults
from friction_audit.diagnosis.prepare import prepare
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Finding, Float, JointLog
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.simulation import BenchSettings, simulate


@pytest.fixture(scope="module")
def clean() -> tuple[JointLog, Interaction, JointData]:
    log = simulate(BenchSettings(duration_s=30.0), 0).log
    estimate = estimate_log(log, AuditSettings())
    (data,) = prepare(estimate.interaction, estimate.cycles, log)
    return log, estimate.interaction, data


def found(clean: tuple[JointLog, Interaction, JointData], data: JointData) -> dict[str, DataFinding]:
    return {finding.code: finding for finding in audit_data(clean[0], clean[1], data, audit_clock(clean[0]))}


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
    clean: tuple[JointLog, Interaction, JointData], change: Callable[[JointData], Float], code: str, size: float
) -> None:
    measured = found(clean, replace(clean[2], logged_dq=change(clean[2])))
    assert code in {one.code for one in measured.values() if one.verdict == "fault"} <= {code, "dq_scale"}
    assert measured[code].value == pytest.approx(size, rel=0.1)


def test_stamps_of_batches_are_a_fault(clean: tuple[JointLog, Interaction, JointData]) -> None:
    log, interaction, data = clean
    batched = replace(log.source, findings=(Finding(code="batched_stamps", message="", amount=9.0),))
    log = replace(log, source=batched)
    codes = {one.code for one in faults(audit_data(log, interaction, data, audit_clock(log)))}
    assert codes == {"batched_stamps"}


def test_a_velocity_that_is_too_large_is_found_where_the_position_is_quieter_too() -> None:
    log = simulate(BenchSettings(duration_s=20.0), 0).log
    for factor, codes in ((1.0, set()), (1.3, {"dq_scale"})):
        spoilt = replace(log, dq=factor * log.dq)
        estimate = estimate_log(spoilt, AuditSettings())
        (data,) = prepare(estimate.interaction, estimate.cycles, spoilt)
        assert data.derived_from == "q"
        assert {
            finding.code for finding in faults(audit_data(spoilt, estimate.interaction, data, audit_clock(spoilt)))
        } == codes


def test_a_motion_that_gains_energy_has_one_score_in_estimate_and_diagnosis() -> None:
    log = simulate(BenchSettings(duration_s=30.0), 0).log
    turned = replace(log, tau_J=log.tau_interaction, tau_interaction=None)  # the hand's row turns it
    estimate = estimate_log(turned, AuditSettings(torque=TorqueSettings(drive="hand")))
    (data,) = prepare(estimate.interaction, estimate.cycles, turned)
    gaining = {one.code: one for one in audit_data(turned, estimate.interaction, data, audit_clock(turned))}["power"]
    (evidence,) = estimate.interaction.choice.sign_evidence
    assert (gaining.verdict, evidence.verdict) == ("fault", "falls")
    assert gaining.value == evidence.score < -10.0
    assert "sign_contradicts_drive" in [one.code for one in estimate.interaction.warnings]


def test_recorder_and_sensor_are_measured(clean: tuple[JointLog, Interaction, JointData]) -> None:
    measured = found(clean, clean[2])
    assert measured["stale"].value == pytest.approx(0.056, abs=0.01)
    assert measured["torque_step"].value == pytest.approx(0.0357, rel=0.01)
    assert measured["holes"].value == 0


def test_one_speed_is_a_limit_and_no_fault(clean: tuple[JointLog, Interaction, JointData]) -> None:
    data = clean[2]
    assert found(clean, replace(data, dq=0.5 * np.sign(data.dq)))["speed_spread"].verdict == "limit"


def test_velocities_of_a_joint_at_rest_are_noise_and_no_fault(clean: tuple[JointLog, Interaction, JointData]) -> None:
    data = clean[2]
    rng = np.random.default_rng(0)
    q, dq = 1e-5 * rng.standard_normal((2, len(data.t)))
    measured = found(clean, replace(data, q=q, dq=dq, logged_dq=dq, cycle=np.full(len(data.t), -1)))
    assert {code for code, finding in measured.items() if finding.verdict == "fault"} == set()
    assert "dq_noise" in measured
