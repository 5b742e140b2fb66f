"""The engine on one likelihood: verdicts, names, intervals, stability, and its numerics against closed forms."""

import numpy as np
import pytest

from friction_audit.diagnosis.diagnose_joint import Subject, diagnose_joint
from friction_audit.diagnosis.noise_model import levinson_durbin
from friction_audit.diagnosis.problem import FOLDS, RegressionProblem, folds_of
from friction_audit.diagnosis.residual_checks import spectral_line
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.selection import occam
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.registry import effects
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import TRUTH, moved_joint


def diagnosed(data: JointData, seed: int = 0, min_effect_nm: float = 0.0) -> JointDiagnosis:
    subject = Subject(data=data, number=1, name="joint1", findings=(), from_energy={})
    return diagnose_joint(subject, effects(), DiagnosisSettings(seed=seed, min_effect_nm=min_effect_nm))


def stribeck(data: JointData) -> Float:
    return 0.1 * data.way * np.exp(-((np.abs(data.dq) / 0.1) ** 2))


def bias(data: JointData) -> Float:
    return np.full(len(data.t), 0.03)


def scattered(data: JointData) -> Float:
    """Coulomb friction that differs from stroke to stroke."""
    size = 0.1 * np.random.default_rng(5).standard_normal(int(data.cycle.max()) + 1)
    return np.asarray(size[data.cycle] * data.way)


def test_adequate_model_has_no_name_and_the_right_numbers() -> None:
    found = diagnosed(moved_joint(noise_nm=0.02))
    assert (found.verdict, found.effects, found.negligible) == ("adequate", (), ())
    for name, truth in TRUTH.items():
        assert found.nominal[name].low <= truth <= found.nominal[name].high
    assert found.gap is not None
    assert found.gap.before == pytest.approx(0.02, rel=0.1)


def test_smoothed_sign_is_no_effect() -> None:
    def smoothed(data: JointData) -> Float:
        return np.asarray(0.3 * (np.tanh(data.dq / 0.004) - data.way))

    assert diagnosed(moved_joint(smoothed, noise_nm=0.01)).verdict == "adequate"


def test_stribeck_is_named_with_its_numbers_for_every_seed() -> None:
    found, again = (diagnosed(moved_joint(stribeck, noise_nm=0.02), seed) for seed in (0, 1))
    assert [e.name for e in found.effects] == ["stribeck"] == [e.name for e in again.effects]
    assert found.verdict == again.verdict == "named"
    (effect,) = found.effects
    for name, truth in (("stribeck_excess_nm", 0.1), ("stribeck_speed_rad_s", 0.1)):
        number = effect.parameters[name]
        assert number.low <= truth <= number.high
    assert effect.gap_after_nm < effect.gap_before_nm
    assert effect.p_value < 0.01


def test_effects_below_the_least_that_counts_are_negligible() -> None:
    found = diagnosed(moved_joint(stribeck, noise_nm=0.02), min_effect_nm=0.5)
    assert (found.verdict, found.effects) == ("adequate", ())
    assert [e.name for e in found.negligible] == ["stribeck"]


def test_offset_is_named_with_what_cannot_be_separated_from_it() -> None:
    found = diagnosed(moved_joint(bias, noise_nm=0.02))
    (effect,) = found.effects
    assert {"torque_bias", "asymmetric_coulomb"} <= {effect.name, *effect.alternatives}
    assert found.verdict == "ambiguous"
    assert effect.decide


def test_friction_that_scatters_is_unexplained() -> None:
    found = diagnosed(moved_joint(scattered, noise_nm=0.02))
    assert found.verdict == "unexplained"
    assert "scatter" in {check.code for check in found.checks}


def test_too_few_cycles_are_not_testable() -> None:
    found = diagnosed(moved_joint(noise_nm=0.02, duration_s=3.0))
    assert found.verdict == "not_testable"
    assert "cycles" in found.message


def test_folds_hold_whole_cycles_spread_over_the_log() -> None:
    cycle = np.repeat(np.arange(23), 7)
    fold = folds_of(cycle)
    assert all(len(set(fold[cycle == c])) == 1 for c in range(23))
    assert np.array_equal(fold, folds_of(cycle))
    for first in range(0, 20, FOLDS):
        assert set(fold[(cycle >= first) & (cycle < first + FOLDS)]) == set(range(FOLDS))


def test_a_dropped_sample_ends_a_stretch() -> None:
    problem = RegressionProblem.build(moved_joint(), None)
    dropped = np.zeros(len(problem.y), bool)
    dropped[100] = True
    assert problem.without(dropped).age[100] == 0
    assert problem.age[100] > 0


def test_levinson_durbin_finds_an_autoregression() -> None:
    # Autocovariance of x_t = 0.6 x_(t-1) - 0.2 x_(t-2) + e_t with unit e_t, from the Yule-Walker equations.
    first, second = 0.6, -0.2
    ratio = first / (1.0 - second)
    variance = 1.0 / (1.0 - first * ratio - second * (first * ratio + second))
    covariance = [variance, variance * ratio]
    for _ in range(3):
        covariance.append(first * covariance[-1] + second * covariance[-2])
    predictors, errors = levinson_durbin(np.array(covariance))
    assert predictors[2, :2] == pytest.approx([first, second])
    assert errors[2:] == pytest.approx(1.0)


def test_evidence_of_no_gain_is_nothing_and_grows_with_the_gain() -> None:
    assert occam(1.0, 2.0) == 0.0
    assert np.all(np.diff(occam(np.array([5.0, 10.0, 50.0]), 2.0)) > 0)


def test_a_line_stands_out_at_its_frequency() -> None:
    t = np.arange(0.0, 60.0, 0.02)
    noise = np.random.default_rng(0).standard_normal(len(t))
    line = spectral_line(noise + 2.0 * np.sin(2 * np.pi * 7.3 * t), t, 0.6, 20.0, np.ones(len(t)))
    assert line is not None
    assert line[0] == pytest.approx(7.3, abs=0.05)
    assert line[1] == pytest.approx(2.0 / 3.0, rel=0.3)
    assert spectral_line(noise, t, 0.6, 20.0, np.ones(len(t))) is None
