"""Replay with the recorded torque or the same operator: the fitted joint moves otherwise than recorded."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.compensators import TorqueRegulation
from friction_audit.compensation.settings import Competitor, ReplaySettings, energy_compensator
from friction_audit.errors import UsageError
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
        (lambda: ReplaySettings(operator=TRUE_HAND), "--operator"),
        (lambda: ReplaySettings(competitor=Competitor(name="disturbance_observer")), "same-motion holds fixed"),
        (lambda: ReplaySettings(compensator=REGULATION), "same-motion holds fixed"),
        (lambda: Competitor(name="magic"), "--compensator magic"),
        (lambda: replace(TRUE_HAND, inertia_kg_m2=-1.0), "--operator -1,9,60"),
    ],
)
def test_contradictions_are_refused(made: Callable[[], object], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        made()
