import re
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.errors import UsageError
from friction_audit.friction.estimate import estimate_friction
from friction_audit.friction.history import JointFriction
from friction_audit.friction.settings import FrictionSettings
from friction_audit.joint_log import Float
from friction_audit.preprocessing.segmentation import segment_cycles
from friction_audit.preprocessing.settings import CycleSettings
from tests.synthetic_interaction import interaction, strokes

COULOMB, VISCOUS, INERTIA = 0.3, 0.07, 0.5
LENGTHS = [0.8, -0.5, 0.6, -0.9, 0.7, -0.6, 0.4, -0.5] * 3
DURATIONS = [1.2, 0.9, 0.7, 1.1, 1.6, 0.8, 1.0, 0.9] * 3
ALONE = FrictionSettings(compare=False)


def estimate(
    t: Float, v: Float, torque: Float, settings: FrictionSettings = ALONE, *, u: Float | None = None
) -> JointFriction:
    log = interaction(t, v, torque, u=u)
    return estimate_friction(log, segment_cycles(log, CycleSettings()), settings).joints[0]


def friction(v: Float, a: Float, coulomb: float = COULOMB, viscous: float = VISCOUS) -> Float:
    return coulomb * np.sign(v) + viscous * v + INERTIA * a


@pytest.mark.parametrize(
    ("model", "coulomb", "viscous"), [("combined", 0.3, 0.07), ("coulomb", 0.3, 0.0), ("viscous", 0.0, 0.07)]
)
@pytest.mark.parametrize("estimator", ["weighted", "paper"])
def test_noise_free_coefficients_are_exact(estimator: str, model: str, coulomb: float, viscous: float) -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    settings = FrictionSettings(estimator=estimator, model=model, compare=False)
    joint = estimate(t, v, friction(v, a, coulomb, viscous), settings)
    if model != "viscous":
        assert joint.coulomb.value == pytest.approx(coulomb, rel=1e-4)
        np.testing.assert_allclose(joint.history.coulomb_nm, coulomb, rtol=1e-3)
    if model != "coulomb":
        assert joint.viscous.value == pytest.approx(viscous, rel=1e-4)
        np.testing.assert_allclose(joint.history.viscous_nms_per_rad, viscous, rtol=1e-3)


def test_the_paper_needs_k_cycles_and_then_estimates_after_each() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    joint = estimate(t, v, friction(v, a), FrictionSettings(estimator="paper", compare=False))
    assert joint.history.cycle.tolist() == list(range(2, 25))
    assert np.isnan(joint.coulomb.low)


def test_the_paper_gives_nothing_where_its_cycles_are_copies() -> None:
    t, v, a = strokes([0.8, -0.8] * 4, [1.0] * 8)
    joint = estimate(t, v, friction(v, a), FrictionSettings(estimator="paper", compare=False))
    assert np.isnan(joint.history.coulomb_nm).all()
    assert np.isnan(joint.coulomb.value)


def test_a_torque_offset_and_a_gravity_error_do_not_reach_the_coefficients() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    q = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    joint = estimate(t, v, friction(v, a) + 0.1 + 0.2 * np.sin(q))
    assert joint.coulomb.value == pytest.approx(COULOMB, rel=1e-3)
    assert joint.viscous.value == pytest.approx(VISCOUS, rel=1e-3)
    assert joint.offset_nm == pytest.approx(0.1, abs=0.01)
    assert joint.gravity_error_nm == pytest.approx(0.2, abs=0.01)


def test_a_logged_compensator_is_corrected_for() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    u = 0.25 * np.sign(v) + 0.05 * v
    for estimator in ("weighted", "paper"):
        joint = estimate(t, v, friction(v, a) - u, FrictionSettings(estimator=estimator, compare=False), u=u)
        assert joint.coulomb.value == pytest.approx(COULOMB, rel=1e-3)
        assert joint.viscous.value == pytest.approx(VISCOUS, rel=1e-3)


def test_passivity_injection_is_corrected_for() -> None:
    """(25): a controller that damps away the whole cycle's energy leaves none at the port, and the estimate stands."""
    t, v, a = strokes(LENGTHS, DURATIONS)
    compensation, passivity = 0.4 * np.sign(v) + 0.1 * v, -(0.1 * np.sign(v) + 0.03 * v)
    joint = estimate(t, v, friction(v, a) - compensation - passivity, u=compensation + passivity)
    assert joint.coulomb.value == pytest.approx(COULOMB, rel=1e-3)
    assert abs(joint.history.net_energy_j[-1]) < 1e-3


def test_a_step_of_friction_is_seen_once_the_window_has_passed_it() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    coulomb = np.where(t < t[-1] / 2, 0.3, 0.6)
    joint = estimate(t, v, friction(v, a) + (coulomb - 0.3) * np.sign(v), FrictionSettings(window=6, compare=False))
    assert joint.history.coulomb_nm[4] == pytest.approx(0.3, rel=0.01)
    assert joint.history.coulomb_nm[-1] == pytest.approx(0.6, rel=0.01)


def test_net_energy_accumulates_the_work() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    joint = estimate(t, v, friction(v, a))
    assert np.all(joint.history.dissipated_j > 0)
    assert np.all(np.diff(joint.history.net_energy_j) > 0)


def test_the_torque_regression_agrees_without_a_hidden_effect() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    noise = 0.05 * np.random.default_rng(0).normal(size=len(t))
    regression = estimate(t, v, friction(v, a) + noise, FrictionSettings()).regression
    assert regression is not None
    assert regression.coulomb.low < COULOMB < regression.coulomb.high
    assert regression.viscous.low < VISCOUS < regression.viscous.high
    assert regression.inertia_kg_m2 == pytest.approx(INERTIA, rel=0.02)
    assert regression.offset_nm == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(
    ("lengths", "durations", "sentence"),
    [
        (
            [0.05, -0.05],
            [1.0, 1.0],
            r"moved too slowly: its speed peaks at 0\.09\d* rad/s, the initiation threshold is 0\.2 rad/s",
        ),
        ([0.001, -0.001], [1.0, 1.0], "did not move: its speed never came near"),
        ([0.8, 0.7, 0.6, 0.5, 0.4], [1.0] * 5, "moved one way only and never back"),
        ([0.8, -0.8], [1.0, 1.0], "only 2 cycles are usable, at least 4 are needed.*--thresholds auto"),
    ],
)
def test_a_joint_without_an_answer_says_which_motion_would_help(
    lengths: list[float], durations: list[float], sentence: str
) -> None:
    t, v, a = strokes(lengths, durations)
    joint = estimate(t, v, friction(v, a))
    assert np.isnan(joint.coulomb.value)
    assert len(joint.history.cycle) == 0
    assert re.search(sentence, joint.reason)


@pytest.mark.parametrize("model", ["combined", "coulomb", "viscous"])
def test_a_position_that_stands_still_while_the_velocity_does_not(model: str) -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    log = interaction(t, v, friction(v, a), q=np.zeros_like(v))
    settings = FrictionSettings(compare=False, model=model)
    joint = estimate_friction(log, segment_cycles(log, CycleSettings()), settings).joints[0]
    assert np.isnan(joint.coulomb.value)
    assert "its position never changes while its velocity does" in joint.reason


def test_one_speed_gives_their_sum_and_not_the_two_coefficients() -> None:
    t = np.arange(0, 20, 0.001)
    v = 0.5 * np.clip(20 * np.sin(np.pi * t), -1, 1)
    joint = estimate(t, v, friction(v, np.gradient(v, t)))
    assert np.isnan(joint.viscous.value)
    assert "all motion has one speed (0.5 rad/s" in joint.reason
    assert "friction there is 0.33" in joint.reason


def test_negative_friction_is_shown_and_warned_about() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    log = interaction(t, v, friction(v, a, coulomb=0.3, viscous=-0.1))
    history = estimate_friction(log, segment_cycles(log, CycleSettings()), ALONE)
    assert history.joints[0].viscous.value == pytest.approx(-0.1, rel=1e-3)
    assert "negative_viscous" in [w.code for w in history.warnings]


def test_a_change_within_the_log_is_said_and_its_absence_is_not() -> None:
    t, v, a = strokes(LENGTHS * 2, DURATIONS * 2)
    noise = 0.01 * np.random.default_rng(0).normal(size=len(t))
    steady, step = friction(v, a) + noise, friction(v, a) + noise + np.where(t < t[-1] / 2, 0.0, 0.3) * np.sign(v)
    codes = []
    for torque in (steady, step):
        log = interaction(t, v, torque)
        codes.append([w.code for w in estimate_friction(log, segment_cycles(log, CycleSettings()), ALONE).warnings])
    assert codes == [[], ["coulomb_changes"]]


def test_two_methods_that_disagree_are_reported_with_what_it_means() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    quadratic = COULOMB * np.sign(v) + 0.3 * v * np.abs(v) + INERTIA * a
    log = interaction(t, v, quadratic)
    history = estimate_friction(log, segment_cycles(log, CycleSettings()), FrictionSettings())
    messages = {w.code: w.message for w in history.warnings}
    assert set(messages) == {"coulomb_disagrees", "viscous_disagrees"}
    assert "friction that is not linear in speed" in messages["viscous_disagrees"]
    regression = history.joints[0].regression
    assert regression is not None
    assert history.joints[0].viscous.value > regression.viscous.value  # energy weighs fast motion more


def test_a_delay_looks_like_viscous_friction_to_both_methods() -> None:
    """A torque that comes d late holds -B d times the jerk; its work over a stroke, B d int ddq^2 dt, is positive."""
    t, v, a = strokes(LENGTHS, DURATIONS)
    log = interaction(t, v, np.interp(t - 0.03, t, friction(v, a)))
    history = estimate_friction(log, segment_cycles(log, CycleSettings()), FrictionSettings())
    regression = history.joints[0].regression
    assert regression is not None
    assert min(history.joints[0].viscous.value, regression.viscous.value) > 2 * VISCOUS
    assert history.warnings == ()


def test_the_smallest_window_is_checked() -> None:
    with pytest.raises(UsageError, match=r"--window 3: the weighted estimator .* needs at least 4 cycles"):
        FrictionSettings(window=3)
    with pytest.raises(UsageError, match=r"--window 1: the paper estimator with the combined model .* at least 2"):
        FrictionSettings(estimator="paper", window=1)
    assert FrictionSettings(estimator="paper", model="viscous", window=1).cycles_per_point == 1


def test_the_regression_ignores_slow_samples_by_the_joints_own_threshold_whoever_defines_the_cycles() -> None:
    t, v, a = strokes(LENGTHS, DURATIONS)
    log = replace(interaction(t, v, friction(v, a)), hand_speed=0.5 * np.abs(v))
    found = [
        estimate_friction(log, segment_cycles(log, CycleSettings(cycles_from=which)), FrictionSettings()).joints[0]
        for which in ("joint", "hand")
    ]
    assert found[0].regression is not None
    assert found[0].regression == found[1].regression
