"""Friction whose coefficients are known, by both methods and both estimators."""

import re
from typing import Any

import numpy as np
import pytest
from scipy.special import stdtrit

from friction_audit.friction.estimate import JointPass, friction_of
from friction_audit.friction.history import FrictionHistory, JointFriction
from friction_audit.friction.settings import FrictionSettings
from friction_audit.friction.weighted import t_quantile
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.reporting.notices import sentence_of, text_of
from tests.effects.joint_data_by_hand import sines
from tests.synthetic_interaction import interaction, passed, strokes

COULOMB, VISCOUS, INERTIA = 0.3, 0.07, 0.5
LENGTHS = [0.8, -0.5, 0.6, -0.9, 0.7, -0.6, 0.4, -0.5] * 3
DURATIONS = [1.2, 0.9, 0.7, 1.1, 1.6, 0.8, 1.0, 0.9] * 3
T, V, A = strokes(LENGTHS, DURATIONS)


def estimated(log: Interaction, joints: list[JointPass] | None = None, **settings: Any) -> FrictionHistory:
    every = passed(log) if joints is None else joints
    return friction_of(log, every, lambda k: every[k].search.cycles(), FrictionSettings(**settings), frozenset())


def alone(t: Float, v: Float, torque: Float, *, u: Float | None = None, **settings: Any) -> JointFriction:
    """Estimate by the energy alone."""
    return estimated(interaction(t, v, torque, u=u), compare=False, **settings).joints[0]


def friction(v: Float, a: Float, coulomb: float = COULOMB, viscous: float = VISCOUS) -> Float:
    return coulomb * np.sign(v) + viscous * v + INERTIA * a


@pytest.mark.parametrize(
    ("model", "coulomb", "viscous"), [("combined", 0.3, 0.07), ("coulomb", 0.3, 0.0), ("viscous", 0.0, 0.07)]
)
@pytest.mark.parametrize("estimator", ["weighted", "paper"])
def test_noise_free_coefficients_are_exact(estimator: str, model: str, coulomb: float, viscous: float) -> None:
    joint = alone(T, V, friction(V, A, coulomb, viscous), estimator=estimator, model=model)
    if model != "viscous":
        assert joint.coulomb.value == pytest.approx(coulomb, rel=1e-4)
        np.testing.assert_allclose(joint.history.coulomb.value, coulomb, rtol=1e-3)
    if model != "coulomb":
        assert joint.viscous.value == pytest.approx(viscous, rel=1e-4)
        np.testing.assert_allclose(joint.history.viscous.value, viscous, rtol=1e-3)


def test_the_paper_needs_k_cycles_and_then_estimates_after_each() -> None:
    joint = alone(T, V, friction(V, A), estimator="paper")
    assert joint.history.cycle.tolist() == list(range(2, 25))
    assert np.isnan(joint.coulomb.low)


def test_the_paper_gives_nothing_where_its_cycles_are_copies() -> None:
    t, v, a = strokes([0.8, -0.8] * 4, [1.0] * 8)
    joint = alone(t, v, friction(v, a), estimator="paper")
    assert np.isnan(joint.history.coulomb.value).all()
    assert np.isnan(joint.coulomb.value)


def test_a_torque_offset_and_a_gravity_error_do_not_reach_the_coefficients() -> None:
    q = np.concatenate([[0.0], np.cumsum(0.5 * (V[1:] + V[:-1]) * np.diff(T))])
    joint = alone(T, V, friction(V, A) + 0.1 + 0.2 * np.sin(q))
    assert joint.coulomb.value == pytest.approx(COULOMB, rel=1e-3)
    assert joint.viscous.value == pytest.approx(VISCOUS, rel=1e-3)
    assert joint.offset_nm == pytest.approx(0.1, abs=0.01)
    assert joint.gravity_error_nm == pytest.approx(0.2, abs=0.01)


def test_a_logged_compensator_is_corrected_for() -> None:
    u = 0.25 * np.sign(V) + 0.05 * V
    for estimator in ("weighted", "paper"):
        joint = alone(T, V, friction(V, A) - u, estimator=estimator, u=u)
        assert joint.coulomb.value == pytest.approx(COULOMB, rel=1e-3)
        assert joint.viscous.value == pytest.approx(VISCOUS, rel=1e-3)


def test_a_step_of_friction_is_seen_once_the_window_has_passed_it() -> None:
    coulomb = np.where(T[-1] / 2 > T, 0.3, 0.6)
    joint = alone(T, V, friction(V, A) + (coulomb - 0.3) * np.sign(V), window=6)
    assert joint.history.coulomb.value[4] == pytest.approx(0.3, rel=0.01)
    assert joint.history.coulomb.value[-1] == pytest.approx(0.6, rel=0.01)


def test_the_torque_regression_agrees_without_a_hidden_effect() -> None:
    noise = 0.05 * np.random.default_rng(0).normal(size=len(T))
    regression: Any = estimated(interaction(T, V, friction(V, A) + noise)).joints[0].regression
    assert regression.coulomb.low < COULOMB < regression.coulomb.high
    assert regression.viscous.low < VISCOUS < regression.viscous.high
    assert regression.inertia.value == pytest.approx(INERTIA, rel=0.02)
    assert regression.offset_nm == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(
    ("lengths", "durations", "sentence"),
    [
        ([0.05, -0.05], [1.0, 1.0], r"moved too slowly: the speed peaks at 0\.09\d* rad/s, below .* threshold 0\.2 "),
        ([0.009, -0.009], [0.3, 0.3], r"hardly moved: by 0\.00\d+ rad"),
        ([0.001, -0.001], [1.0, 1.0], "did not move: the speed stays far below"),
        ([0.8, 0.7, 0.6, 0.5, 0.4], [1.0] * 5, "all motion that counts has one direction"),
        ([0.8, -0.8], [1.0, 1.0], "fewer than 4 usable cycles; .*--thresholds auto"),
    ],
)
def test_a_joint_without_an_answer_says_which_motion_would_help(
    lengths: list[float], durations: list[float], sentence: str
) -> None:
    t, v, a = strokes(lengths, durations)
    joint = alone(t, v, friction(v, a))
    assert np.isnan(joint.coulomb.value)
    assert len(joint.history.cycle) == 0
    assert re.search(sentence, text_of(joint.reason))


@pytest.mark.parametrize("model", ["combined", "coulomb", "viscous"])
def test_a_position_that_stands_still_while_the_velocity_does_not(model: str) -> None:
    log = interaction(T, V, friction(V, A), q=np.zeros_like(V))
    joint = estimated(log, compare=False, model=model).joints[0]
    assert np.isnan(joint.coulomb.value)
    assert "the position never changes while the velocity does" in text_of(joint.reason)


def test_one_speed_gives_their_sum_and_not_the_two_coefficients() -> None:
    t = np.arange(0, 20, 0.001)
    v = 0.5 * np.clip(20 * np.sin(np.pi * t), -1, 1)
    joint = alone(t, v, friction(v, np.gradient(v, t)))
    assert np.isnan(joint.viscous.value)
    assert re.search(r"all motion has one speed \(0\.5 rad/s.* friction there is 0\.33", text_of(joint.reason))


@pytest.mark.parametrize(("noise_nm", "rel", "words"), [(0.0, 1e-3, "is in the torque"), (5.0, 1.0, "not different")])
def test_negative_friction_is_shown_and_warned_about(noise_nm: float, rel: float, words: str) -> None:
    noise = noise_nm * np.random.default_rng(0).normal(size=len(T))
    history = estimated(interaction(T, V, friction(V, A, coulomb=0.3, viscous=-0.1) + noise), compare=False)
    assert history.joints[0].viscous.value == pytest.approx(-0.1, rel=rel)
    assert words in next(sentence_of(w) for w in history.warnings if w.code == "negative_viscous")


def test_a_change_within_the_log_is_said_and_its_absence_is_not() -> None:
    t, v, a = strokes(LENGTHS * 2, DURATIONS * 2)
    noise = 0.01 * np.random.default_rng(0).normal(size=len(t))
    steady, step = friction(v, a) + noise, friction(v, a) + noise + np.where(t < t[-1] / 2, 0.0, 0.3) * np.sign(v)
    histories = [estimated(interaction(t, v, torque), compare=False) for torque in (steady, step)]
    codes = [[w.code for w in history.warnings] for history in histories]
    assert codes == [[], ["coulomb_changes"]]


def test_a_recording_that_is_twice_in_a_log_is_said() -> None:
    """Copies of cycles made intervals narrower by the square root of two."""
    lengths = [*LENGTHS, -sum(LENGTHS)]
    t, v, a = strokes(lengths, [*DURATIONS, 2.0])
    torque = friction(v, a) + 0.01 * np.random.default_rng(0).normal(size=len(t))
    codes = [
        [one.code for one in estimated(interaction(*signals), compare=False).warnings]
        for signals in ((t, v, torque), (np.append(t, t + t[-1] + 1e-3), np.tile(v, 2), np.tile(torque, 2)))
    ]
    assert codes == [[], ["cycles_repeated"]]


def test_two_methods_that_disagree_are_reported_with_what_it_means() -> None:
    history = estimated(interaction(T, V, COULOMB * np.sign(V) + 0.3 * V * np.abs(V) + INERTIA * A))
    messages = {w.code: sentence_of(w) for w in history.warnings}
    assert set(messages) == {"coulomb_disagrees", "viscous_disagrees"}
    assert "friction that is not linear in speed" in messages["viscous_disagrees"]
    regression: Any = history.joints[0].regression
    assert history.joints[0].viscous.value > regression.viscous.value  # energy weighs fast motion more
    assert all(covers(history.joints[0], name) for name in ("coulomb", "viscous"))


def test_a_delay_looks_like_viscous_friction_to_both_methods() -> None:
    """A torque that comes d late holds -B d times the jerk; its work over a stroke, B d int ddq^2 dt, is positive."""
    history = estimated(interaction(T, V, np.interp(T - 0.03, T, friction(V, A))))
    regression: Any = history.joints[0].regression
    assert min(history.joints[0].viscous.value, regression.viscous.value) > 2 * VISCOUS
    (warning,) = history.warnings
    assert (warning.code, warning.numbers["late"]) == ("torque_delayed", "late")
    assert warning.numbers["ms"] == pytest.approx(30.0, rel=0.05)


def test_the_regression_ignores_slow_samples_by_the_joints_own_threshold_whoever_defines_the_cycles() -> None:
    log = interaction(T, V, friction(V, A))
    passes = passed(log), passed(log, CycleSettings(cycles_from="hand"), hand_speed=0.5 * np.abs(V))
    found = [estimated(log, joints).joints[0] for joints in passes]
    assert found[0].regression == found[1].regression is not None


def excitation(phase: float) -> tuple[Float, Float, Float, Float]:
    """Sines without a common period on a slow slope: no path returns to where it began."""
    t = np.arange(0.0, 30.0, 0.004)
    q, v, a = sines(t, (0.5, 1.3, phase), (0.3, 2.1, 2 * phase), (0.15, 3.7, 1.0))
    return t, 0.2 * t + q, 0.2 + v, a


def two_joints(coupling: float) -> Interaction:
    (t, q1, v1, a1), (_, q2, v2, a2) = excitation(0.0), excitation(2.0)
    noise = 0.02 * np.random.default_rng(1).normal(size=(len(t), 2))
    first = 0.3 * np.sign(v1) + 0.1 * v1 + 0.2 * a1 + 0.8 * np.sin(q1)
    second = 0.3 * np.sign(v2) + 0.1 * v2 + 0.2 * a2 + 0.8 * np.cos(q2)
    torque = np.stack([first + coupling * (np.sign(v2) + v2), second], axis=1) + noise
    return interaction(t, np.stack([v1, v2], axis=1), torque, q=np.stack([q1, q2], axis=1), gravity="in-torque")


def test_excitation_without_a_closed_cycle_is_answered_by_a_regression() -> None:
    history = estimated(two_joints(coupling=0.0))
    for joint in history.joints:
        assert (joint.method, joint.reason, joint.cycles, len(joint.history.cycle)) == ("regression", (), 0, 0)
        assert joint.coulomb.value == pytest.approx(0.3, rel=0.1)
        assert joint.viscous.value == pytest.approx(0.1, rel=0.1)
        assert joint.coulomb.low < 0.3 < joint.coulomb.high
    assert [(one.code, one.joint) for one in history.warnings] == [("from_regression", 1), ("from_regression", 2)]


def test_a_joint_whose_torque_follows_another_is_refused_with_its_name_and_takes_none_along() -> None:
    coupled, alone = estimated(two_joints(coupling=0.1)).joints
    assert np.isnan(coupled.coulomb.value)
    assert "the velocity of joint 2" in text_of(coupled.reason)
    assert alone.method == "regression"


@pytest.mark.parametrize("settings", [{"compare": False}, {"estimator": "paper"}, {"model": "coulomb"}])
def test_no_other_method_than_the_one_asked_for(settings: dict[str, Any]) -> None:
    assert all(joint.reason for joint in estimated(two_joints(coupling=0.0), **settings).joints)


def test_a_torque_of_noise_is_not_answered_by_a_regression() -> None:
    t, q, v, _ = excitation(0.0)
    noise = np.random.default_rng(0).normal(size=len(t))
    (joint,) = estimated(interaction(t, v, noise, q=q, gravity="in-torque")).joints
    assert "No torque regression either" in text_of(joint.reason)


def covers(joint: JointFriction, name: str) -> bool:
    """Whether the interval of the log and of the last point of its history hold the regression's interval."""
    one, other = getattr(joint, name), getattr(joint.regression, name)
    _, *last = (ends[-1] for ends in getattr(joint.history, name))
    own = bool(one.low <= min(one.value, other.low) and max(one.value, other.high) <= one.high)
    return own and bool(last[1] - last[0] >= one.high - one.low - 1e-9)


def log_of(lengths: list[float], durations: list[float], *, stribeck_nm: float) -> Interaction:
    t, v, a = strokes(lengths, durations)
    noise = 0.02 * np.random.default_rng(2).normal(size=len(t))
    falling = stribeck_nm * np.exp(-((v / 0.15) ** 2)) * np.sign(v)
    return interaction(t, v, 0.3 * np.sign(v) + 0.1 * v + 0.2 * a + falling + noise)


def test_cycles_of_one_speed_profile_have_intervals_that_hold_both_methods() -> None:
    history = estimated(log_of([0.8, -0.8] * 8, [1.2] * 16, stribeck_nm=0.1))
    (joint,) = history.joints
    assert covers(joint, "coulomb")
    assert covers(joint, "viscous")
    assert "one_speed_profile" in [one.code for one in history.warnings]


@pytest.mark.parametrize("settings", [{"model": "coulomb"}, {"estimator": "paper"}])
def test_one_speed_profile_matters_only_where_two_coefficients_are_separated(settings: dict[str, Any]) -> None:
    history = estimated(log_of([0.8, -0.8] * 8, [1.2] * 16, stribeck_nm=0.0), **settings)
    assert "one_speed_profile" not in [one.code for one in history.warnings]
    assert np.isnan(history.joints[0].viscous.low)


def test_a_coefficient_with_an_interval_beyond_any_torque_is_not_determined() -> None:
    """Slow noise, on strokes of nearly one speed."""
    t = np.arange(0.0, 9.0, 0.004)
    v = 0.5 * np.clip(8 * np.sin(np.pi * t), -1, 1) * (1 + 0.2 * np.sin(2 * np.pi * t))
    knots = np.arange(0.0, 9.2, 0.2)
    noise = np.interp(t, knots, np.random.default_rng(1).normal(size=len(knots)))
    (joint,) = estimated(interaction(t, v, noise), compare=False).joints
    assert np.isnan([joint.coulomb.value, joint.viscous.value]).all()
    assert "do not determine its friction" in text_of(joint.reason)
    assert np.isnan(joint.history.viscous.value).any()


def test_a_dead_velocity_is_named_and_not_taken_for_standstill() -> None:
    t, q, v, _ = excitation(0.0)
    (joint,) = estimated(interaction(t, 0.0 * v, np.sign(v), q=q)).joints
    assert [one.code for one in joint.reason] == ["dead_velocity"]


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 9, 10, 101, 5000])
def test_half_widths_are_those_of_students_t(freedom: int) -> None:
    assert t_quantile(freedom) == pytest.approx(stdtrit(freedom, 0.975), rel=1e-12)
