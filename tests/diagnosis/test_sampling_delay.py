"""A torque that comes a fraction of a millisecond late, in logs with long and with short steps."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.diagnose_joint import Subject, diagnose_joint
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_data import mean_sign
from friction_audit.effects.presliding import EFFECT as PRESLIDING
from friction_audit.effects.time_delay import EFFECT as TIME_DELAY
from tests.diagnosis.moved_joint import TRUTH, moved_joint

LATE_S = 4e-4


def diagnosed(sample_s: float, late_s: float = LATE_S) -> JointDiagnosis:
    exact, noisy = moved_joint(), moved_joint(noise_nm=0.002)
    late = np.interp(exact.t - late_s, exact.t, exact.torque) - exact.torque
    data = replace(noisy, torque=noisy.torque + late, sample_s=sample_s)
    return diagnose_joint(
        Subject(data=data, number=1, name="joint1", findings=(), from_energy={}), (TIME_DELAY,), DiagnosisSettings()
    )


@pytest.mark.parametrize("late_s", [LATE_S, -LATE_S])
def test_less_than_half_a_sample_is_put_on_time_and_told_as_a_number_of_the_data(late_s: float) -> None:
    found = diagnosed(1e-3, late_s)
    assert (found.verdict, found.effects) == ("adequate", ())
    (finding,) = found.findings
    assert (finding.code, finding.verdict, finding.bound) == ("torque_delay", "fine", 5e-4)
    assert finding.value == pytest.approx(late_s, rel=0.1)


@pytest.mark.parametrize("sample_s", [0.0, 7e-4])
def test_half_a_sample_and_more_is_an_effect(sample_s: float) -> None:
    found = diagnosed(sample_s)
    assert [effect.name for effect in found.effects] == ["time_delay"]
    assert found.findings == ()


def turned(early_s: float, sample_s: float) -> JointDiagnosis:
    """A joint whose friction alone turns before its velocity does."""
    data = moved_joint(noise_nm=0.002)
    early = TRUTH["coulomb_nm"] * (mean_sign(data.t, data.dq + early_s * data.ddq, data.ddq) - data.way)
    data = replace(data, torque=data.torque + early, sample_s=sample_s)
    return diagnose_joint(
        Subject(data=data, number=1, name="joint1", findings=(), from_energy={}), (PRESLIDING,), DiagnosisSettings()
    )


def test_friction_that_turns_within_a_sample_is_put_on_time_too() -> None:
    found = turned(LATE_S, 1e-3)
    assert (found.verdict, found.effects) == ("adequate", ())
    (finding,) = found.findings
    assert (finding.code, finding.verdict, finding.bound) == ("friction_delay", "fine", 1e-3)
    assert finding.value == pytest.approx(-LATE_S, rel=0.1)


def test_what_takes_longer_builds_up() -> None:
    found = turned(LATE_S, 0.5 * LATE_S)
    assert [effect.name for effect in found.effects] == ["presliding"]
    assert found.findings == ()
