"""Which method gives the coefficients, and what their intervals hold."""

from typing import Any

import numpy as np
import pytest

from friction_audit.friction.estimate import estimate_friction
from friction_audit.friction.history import FrictionHistory, JointFriction
from friction_audit.friction.settings import FrictionSettings
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.segmentation import segment_cycles
from friction_audit.preprocessing.settings import CycleSettings
from tests.synthetic_interaction import interaction, strokes

COULOMB, VISCOUS, INERTIA = 0.3, 0.1, 0.2


def estimated(log: Interaction, **settings: Any) -> FrictionHistory:
    return estimate_friction(log, segment_cycles(log, CycleSettings()), FrictionSettings(**settings))


def excitation(phase: float) -> tuple[Float, Float, Float, Float]:
    """Sines without a common period on a slow slope: no path returns to where it began."""
    t = np.arange(0.0, 30.0, 0.004)
    terms = [(0.5, 1.3, phase), (0.3, 2.1, 2 * phase), (0.15, 3.7, 1.0)]
    q = 0.2 * t + sum(size * np.sin(w * t + shift) for size, w, shift in terms)
    v = 0.2 + sum(size * w * np.cos(w * t + shift) for size, w, shift in terms)
    a = -sum(size * w**2 * np.sin(w * t + shift) for size, w, shift in terms)
    return t, np.asarray(q), np.asarray(v), np.asarray(a)


def two_joints(coupling: float) -> Interaction:
    (t, q1, v1, a1), (_, q2, v2, a2) = excitation(0.0), excitation(2.0)
    noise = 0.02 * np.random.default_rng(1).normal(size=(len(t), 2))
    first = COULOMB * np.sign(v1) + VISCOUS * v1 + INERTIA * a1 + 0.8 * np.sin(q1)
    second = COULOMB * np.sign(v2) + VISCOUS * v2 + INERTIA * a2 + 0.8 * np.cos(q2)
    torque = np.stack([first + coupling * (np.sign(v2) + v2), second], axis=1) + noise
    return interaction(t, np.stack([v1, v2], axis=1), torque, q=np.stack([q1, q2], axis=1), gravity="none")


def test_excitation_without_a_closed_cycle_is_answered_by_a_regression() -> None:
    history = estimated(two_joints(coupling=0.0))
    for joint in history.joints:
        assert (joint.method, joint.reason, joint.cycles, len(joint.history.cycle)) == ("regression", "", 0, 0)
        assert joint.coulomb.value == pytest.approx(COULOMB, rel=0.1)
        assert joint.viscous.value == pytest.approx(VISCOUS, rel=0.1)
        assert joint.coulomb.low < COULOMB < joint.coulomb.high
    assert [(one.code, one.joint) for one in history.warnings] == [("from_regression", 1), ("from_regression", 2)]


def test_a_joint_whose_torque_follows_another_is_refused_with_its_name_and_takes_none_along() -> None:
    coupled, alone = estimated(two_joints(coupling=0.1)).joints
    assert np.isnan(coupled.coulomb.value)
    assert "the velocity of joint 2" in coupled.reason
    assert alone.method == "regression"


@pytest.mark.parametrize("settings", [{"compare": False}, {"estimator": "paper"}, {"model": "coulomb"}])
def test_no_other_method_than_the_one_asked_for(settings: dict[str, Any]) -> None:
    assert all(joint.reason for joint in estimated(two_joints(coupling=0.0), **settings).joints)


def test_a_torque_of_noise_is_not_answered_by_a_regression() -> None:
    t, q, v, _ = excitation(0.0)
    (joint,) = estimated(interaction(t, v, np.random.default_rng(0).normal(size=len(t)), q=q, gravity="none")).joints
    assert "No torque regression either" in joint.reason


def covers(joint: JointFriction, name: str) -> bool:
    """Whether the interval of the log and of the last point of its history hold the regression's interval."""
    one, other = getattr(joint, name), getattr(joint.regression, name)
    unit = {"coulomb": "nm", "viscous": "nms_per_rad"}[name]
    last = [getattr(joint.history, f"{name}_{end}_{unit}")[-1] for end in ("low", "high")]
    own = bool(one.low <= min(one.value, other.low) and max(one.value, other.high) <= one.high)
    return own and bool(last[1] - last[0] >= one.high - one.low - 1e-9)


def log_of(lengths: list[float], durations: list[float], *, stribeck_nm: float) -> Interaction:
    t, v, a = strokes(lengths, durations)
    noise = 0.02 * np.random.default_rng(2).normal(size=len(t))
    falling = stribeck_nm * np.exp(-((v / 0.15) ** 2)) * np.sign(v)
    return interaction(t, v, COULOMB * np.sign(v) + VISCOUS * v + INERTIA * a + falling + noise)


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


def test_methods_that_disagree_have_intervals_that_hold_both() -> None:
    lengths, durations = [0.8, -0.5, 0.6, -0.9, 0.7, -0.6, 0.4, -0.5] * 3, [1.2, 0.9, 0.7, 1.1, 1.6, 0.8, 1.0, 0.9] * 3
    t, v, a = strokes(lengths, durations)
    (joint,) = estimated(interaction(t, v, COULOMB * np.sign(v) + 0.3 * v * np.abs(v) + INERTIA * a)).joints
    assert covers(joint, "coulomb")
    assert covers(joint, "viscous")


def test_methods_that_agree_leave_the_interval_of_the_energy() -> None:
    log = log_of(
        [0.8, -0.5, 0.6, -0.9, 0.7, -0.6, 0.4, -0.5] * 2, [1.2, 0.9, 0.7, 1.1, 1.6, 0.8, 1.0, 0.9] * 2, stribeck_nm=0
    )
    both, alone = estimated(log), estimated(log, compare=False)
    assert both.joints[0].coulomb == alone.joints[0].coulomb
    assert both.warnings == ()


def test_a_coefficient_with_an_interval_beyond_any_torque_is_not_determined() -> None:
    """Slow noise, on strokes of nearly one speed."""
    t = np.arange(0.0, 9.0, 0.004)
    v = 0.5 * np.clip(8 * np.sin(np.pi * t), -1, 1) * (1 + 0.2 * np.sin(2 * np.pi * t))
    knots = np.arange(0.0, 9.2, 0.2)
    noise = np.interp(t, knots, np.random.default_rng(1).normal(size=len(knots)))
    (joint,) = estimated(interaction(t, v, noise), compare=False).joints
    assert np.isnan([joint.coulomb.value, joint.viscous.value]).all()
    assert "do not determine its friction" in joint.reason
    assert np.isnan(joint.history.viscous_nms_per_rad).any()


def test_a_dead_velocity_is_named_and_not_taken_for_standstill() -> None:
    t, q, v, _ = excitation(0.0)
    (joint,) = estimated(interaction(t, 0.0 * v, np.sign(v), q=q)).joints
    assert "dq is dead" in joint.reason
    assert "did not move" not in joint.reason
