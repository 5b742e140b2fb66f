"""Replay where the fitted joint moves otherwise than recorded; steps of friction and cycles of the hand by hand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.closed_loop import CYCLE
from friction_audit.compensation.competitors import TorqueRegulation
from friction_audit.compensation.controller import hand_cuts
from friction_audit.compensation.result import ReplayHistory, dissipation_removed, find_step, first_right
from friction_audit.compensation.settings import Competitor, ReplaySettings, energy_compensator
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.bench import Operator
from friction_audit.simulation.settings import PANDA_SENSORS
from friction_audit.simulation.strokes import StopAndGo
from tests.compensation.bench import BENCH, BY_HAND, TRUE_HAND, log_of, replay

MINUTE = replace(BENCH, duration_s=60.0)
COMPENSATOR = energy_compensator()


@pytest.mark.parametrize("operator", [BY_HAND, Operator(motion=StopAndGo())], ids=["sinusoid", "stop and go"])
def test_the_same_operator_is_foretold(operator: Operator) -> None:
    """What the simulator makes of operator, joint and compensator, replay foretells from the log without one."""
    bench = replace(MINUTE, operator=operator)
    joint = replay(
        log_of(bench), ReplaySettings(assume="same-operator", operator=TRUE_HAND, compensator=COMPENSATOR)
    ).joints[0]
    happened: Any = log_of(replace(bench, compensator=COMPENSATOR))
    assert joint.model_error < 1e-3
    np.testing.assert_allclose(joint.replayed.dq, happened.dq[:, 0], atol=5e-3)
    np.testing.assert_allclose(joint.replayed.compensation_nm, happened.tau_compensation[:, 0], atol=0.03)
    assert joint.numbers.dissipation_removed_updated > 0.99


def test_the_operator_is_fitted_from_quick_reversals() -> None:
    noisy = replace(MINUTE, sensors=(PANDA_SENSORS[0],), duration_s=120.0)
    for log, bound in ((log_of(replace(MINUTE, duration_s=120.0)), 0.08), (log_of(noisy), 0.2)):
        joint = replay(log, ReplaySettings(assume="same-operator", compensator=COMPENSATOR)).joints[0]
        hand = joint.operator
        assert hand.reversals >= 20
        assert hand.inertia.value == pytest.approx(0.3, rel=bound)
        assert hand.damping.value == pytest.approx(9.0, rel=bound)
        assert hand.stiffness.value == pytest.approx(60.0, rel=bound)
        for number, truth in ((hand.inertia, 0.3), (hand.damping, 9.0), (hand.stiffness, 60.0)):
            assert number.low < truth < number.high


def test_a_person_who_pauses_cannot_be_fitted() -> None:
    log = log_of(replace(MINUTE, operator=Operator(motion=StopAndGo())))
    found = replay(log, ReplaySettings(assume="same-operator"))
    assert "quick reversals" in found.joints[0].reason
    assert "--operator" in found.joints[0].reason
    assert [caution.code for caution in found.warnings] == ["not_replayed"]


def test_the_same_torque_moves_a_compensated_joint_farther() -> None:
    joint = replay(log_of(MINUTE), ReplaySettings(assume="same-torque", compensator=COMPENSATOR)).joints[0]
    history, replayed = joint.history, joint.replayed
    assert joint.fitted.inertia.value == pytest.approx(0.3, rel=0.01)
    assert joint.model_error < 1e-3
    np.testing.assert_allclose(replayed.interaction_nm, joint.without.interaction_nm, atol=1e-9)
    assert np.abs(replayed.dq[20000:]).mean() > 1.2 * np.abs(joint.without.dq[20000:]).mean()
    # The ridge starts from no friction; two updates later it has the split.
    np.testing.assert_allclose(history.coulomb_estimated_nm[5:], 0.3, rtol=0.03)
    np.testing.assert_allclose(history.viscous_estimated_nms_per_rad[5:], 0.07, rtol=0.1)


def test_a_competitor_that_diverges_is_cut_there_and_said_so() -> None:
    competitor = Competitor(name="torque_regulation", desired_inertia_kg_m2=0.02)
    found = replay(log_of(MINUTE), ReplaySettings(assume="same-operator", operator=TRUE_HAND, competitor=competitor))
    joint = found.joints[0]
    assert 0.0 < joint.numbers.diverged_s < 60.0
    assert joint.replayed.t[-1] < joint.numbers.diverged_s
    assert np.isfinite(joint.replayed.dq).all()
    assert "diverged" in {caution.code for caution in found.warnings}


@pytest.mark.parametrize("name", ["fixed", "sigmoid", "lugre", "disturbance_observer", "torque_regulation"])
def test_competitors_are_tuned_from_the_log(name: str) -> None:
    settings = ReplaySettings(assume="same-operator", operator=TRUE_HAND, competitor=Competitor(name=name))
    joint = replay(log_of(MINUTE), settings).joints[0]
    assert np.isnan(joint.numbers.diverged_s)
    assert joint.numbers.dissipation_removed > (0.4 if name == "torque_regulation" else 0.8)


def test_an_inertia_that_the_log_does_not_tell_is_refused() -> None:
    log: Any = log_of(MINUTE)
    ddq = np.gradient(log.dq[:, 0], log.t)
    massless = replace(log, tau_interaction=log.tau_interaction - 0.3 * ddq[:, None])
    joint = replay(massless, ReplaySettings(assume="same-torque")).joints[0]
    assert "inertia is not determined" in joint.reason


REGULATION = TorqueRegulation(inertia_kg_m2=0.3, desired_inertia_kg_m2=0.2)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: ReplaySettings(assume="wrong"), "--assume wrong"),
        (lambda: ReplaySettings(compensator=REGULATION), "same-motion holds fixed"),
        (lambda: Competitor(name="magic"), "--compensator magic"),
        (lambda: replace(TRUE_HAND, inertia_kg_m2=-1.0), "--operator -1,9,60"),
    ],
)
def test_contradictions_are_refused(made: Callable[[], object], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        made()


# Parts of a replay by hand.


def history(friction: list[float], left: list[float]) -> ReplayHistory:
    made = np.zeros(len(friction), CYCLE).view(np.recarray)
    made.friction_j, made.net_energy_j = friction, left
    return made


def test_what_is_given_out_counts_as_left_over() -> None:
    found = history([1.0, 1.0, 2.0], [1.0, -0.5, 0.5])
    assert dissipation_removed(found) == pytest.approx(0.5)
    assert dissipation_removed(history([1.0], [-0.5])) == pytest.approx(0.5)
    assert np.isnan(dissipation_removed(found, 3))
    assert np.isnan(dissipation_removed(history([-1.0], [0.0])))


def test_right_means_three_in_a_row() -> None:
    left = [1.0, 0.05, 0.5, 0.1, -0.1, 0.0, 0.9]
    assert first_right(history([1.0] * 7, left)) == 3
    assert first_right(history([1.0] * 7, left), 4) is None
    assert first_right(history([1.0, 1.0], [0.0, 0.0])) is None


def cycles(after: float, at: int, count: int = 24) -> tuple[Float, Float, Float]:
    """Return path, squared speed and friction of strokes at changing speed, of which friction changes at one."""
    path = 0.5 + 0.2 * np.sin(np.arange(count))
    speed = 0.8 + 0.3 * np.cos(2.0 * np.arange(count))
    factor = np.where(np.arange(count) < at, 1.0, after)
    return path, path * speed, factor * path * (0.3 + 0.1 * speed)


def test_neither_speed_nor_noise_nor_warming_up_is_a_step() -> None:
    rng = np.random.default_rng(2)
    path, square, friction = cycles(1.0, 10)
    assert find_step(path, square, friction) is None
    for _ in range(20):
        assert find_step(path, square, friction * (1.0 + 0.2 * rng.standard_normal(len(path)))) is None
    assert find_step(path, square, friction * np.linspace(2.0, 1.0, len(path))) is None
    assert find_step(path[:5], square[:5], friction[:5]) is None
    assert find_step(0.0 * path, square, friction) is None


def test_the_hand_ends_cycles_when_all_joints_have_moved() -> None:
    t: Float = np.arange(4001, dtype=np.float64) * 1e-3
    speed = np.abs(np.sin(np.pi * t))
    dq = np.stack([np.sin(np.pi * t), np.where(t < 1.0, 0.0, np.sin(np.pi * t))], axis=1)

    def cuts(minimum_path_rad: float) -> list[float]:
        found = hand_cuts(t, speed, dq, (0.1, 0.025), 0.01, minimum_path_rad)
        return [float(t[i]) for i in np.flatnonzero(found)]

    # The second joint stands still in the first second: its cycle is the first two.
    np.testing.assert_allclose(cuts(0.1), [2.0, 3.0, 4.0], atol=0.02)
    np.testing.assert_allclose(cuts(0.0), [1.0, 2.0, 3.0, 4.0], atol=0.02)
    assert cuts(10.0) == []
