"""What holds for every method."""

from dataclasses import replace

import pytest

from friction_audit.compensation.comparison import METHODS, SCENES
from friction_audit.compensation.comparison.methods import OBSERVED_SHARE, Joint, Method, Tuning
from friction_audit.compensation.compensators import Compensator, DisturbanceObserver, TorqueRegulation

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
def test_sweeps_go_from_careful_to_bold(method: Method) -> None:
    for sweep in method.sweeps:
        assert list(sweep.values) == sorted(sweep.values)


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
