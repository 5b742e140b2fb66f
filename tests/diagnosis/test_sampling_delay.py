"""A recorder that is late by less than half a sample is a nuisance; a longer delay is an effect with its size."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.diagnose_joint import Subject, diagnose_joint
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.time_delay import EFFECT as TIME_DELAY
from tests.diagnosis.moved_joint import moved_joint


def diagnosed(sample_s: float, late_s: float) -> JointDiagnosis:
    exact, noisy = moved_joint(), moved_joint(noise_nm=0.002)
    late = np.interp(exact.t - late_s, exact.t, exact.torque) - exact.torque
    data = replace(noisy, torque=noisy.torque + late, sample_s=sample_s)
    return diagnose_joint(
        Subject(data=data, number=1, name="joint1", findings=(), from_energy={}), (TIME_DELAY,), DiagnosisSettings()
    )


@pytest.mark.parametrize("late_s", [4e-4, -4e-4])
def test_less_than_half_a_sample_is_no_effect(late_s: float) -> None:
    found = diagnosed(1e-3, late_s)
    assert (found.verdict, found.effects, found.negligible) == ("adequate", (), ())


def test_with_exact_stamps_it_is_a_negligible_effect() -> None:
    found = diagnosed(0.0, 4e-4)
    assert (found.verdict, [effect.name for effect in found.negligible]) == ("adequate", ["time_delay"])


def test_two_samples_are_named_with_their_size_and_without_the_shape_that_the_log_cannot_show() -> None:
    (effect,) = diagnosed(1e-3, 2e-3).effects
    assert effect.name == "time_delay"
    delay = effect.parameters["delay_s"]
    assert delay.low < 2e-3 < delay.high
    assert delay.high - delay.low < 1e-3
    assert effect.not_identifiable == ("delay_step_s",)
