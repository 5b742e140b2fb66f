"""What holds for every method."""

from dataclasses import fields, replace

import pytest

from friction_audit.compensation.comparison import METHODS, SCENES
from friction_audit.compensation.comparison.methods import OBSERVED_SHARE, Joint, Method, Tuning
from friction_audit.compensation.comparison.trial import Outcome, find_reference, measure
from friction_audit.compensation.compensators import Compensator, DisturbanceObserver, TorqueRegulation
from friction_audit.simulation.scenarios import simulate
from tests.comparison.conftest import short_joint

EACH = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)


def tunings(method: Method) -> list[Tuning]:
    own = [method.paper] if method.full is None else [method.paper, method.full]
    return [*own, *method.others, *(sweep.at(value) for sweep in method.sweeps for value in sweep.values)]


@EACH
def test_every_tuning_makes_a_compensator_for_every_joint(method: Method) -> None:
    for joint in SCENES[1].joints:
        for tuning in tunings(method):
            assert isinstance(tuning.make(joint), Compensator)
            assert tuning.name
            assert tuning.meaning
            tuning.make(joint).scaled(2.0)


@EACH
def test_the_same_tuning_is_the_same_compensator(method: Method) -> None:
    joint = SCENES[0].joints[0]
    for tuning in tunings(method):
        assert tuning.make(joint) == tuning.make(joint)


@EACH
def test_sweeps_go_from_careful_to_bold(method: Method) -> None:
    for sweep in method.sweeps:
        assert list(sweep.values) == sorted(sweep.values)


@EACH
def test_a_trial_has_numbers(method: Method) -> None:
    scene = short_joint()
    tuning = tunings(method)[0]
    reference = find_reference(simulate(scene.compensated(METHODS[0].paper), 0))
    outcome = measure(simulate(scene.compensated(tuning), 0), reference)
    numbers = [getattr(outcome, item.name) for item in fields(Outcome) if item.name != "lost_s"]
    assert all(number == number for number in numbers)  # noqa: PLR0124 - not NaN
    assert outcome.stable


def test_joints_have_the_limits_of_a_panda() -> None:
    limits = [joint.guard.max_torque_nm for joint in SCENES[1].joints]
    assert limits == [87.0] * 4 + [12.0] * 3
    compensator = next(one for one in METHODS if one.name == "torque_regulation").sweeps[0].at(1.0).make(joint_six())
    assert isinstance(compensator, TorqueRegulation)
    assert compensator.guard.max_torque_nm == 12.0
    assert compensator.torque_gain == pytest.approx(1.0)


def test_the_two_named_settings_differ_in_the_share_of_the_observer_alone() -> None:
    (method,) = (one for one in METHODS if one.full is not None)
    assert method.full is not None
    partly, fully = method.paper.make(joint_six()), method.full.make(joint_six())
    assert isinstance(fully, DisturbanceObserver)
    assert fully.compensation_gain == 1.0
    assert partly == replace(fully, compensation_gain=OBSERVED_SHARE)


def joint_six() -> Joint:
    return SCENES[1].joints[5]
