"""What an effect is drawn along: its own angle, one of its waves, or its own torque."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.discrepancy.result import Effect
from friction_audit.report.figures.diagnose_own_axis import own_axis
from tests.report.diagnosis_by_hand import STRIBECK, coefficient, traces

TRACES = traces(4)
TORQUE = np.linspace(-0.1, 0.2, len(TRACES.t))


def effect(name: str, **parameters: float) -> Effect:
    numbers = {key: coefficient(value, 0.0) for key, value in parameters.items()}
    return replace(STRIBECK, name=name, parameters=numbers, torque=TORQUE)


def test_what_goes_by_the_joint_s_own_motion_needs_no_axis_of_its_own() -> None:
    assert own_axis(effect("stribeck", stribeck_excess_nm=0.1), TRACES) is None
    assert own_axis(effect("gravity_error", gravity_error_source=0.0), TRACES) is None


def test_waves_are_laid_over_each_other() -> None:
    own = own_axis(effect("torque_ripple", ripple_order=100.0), replace(TRACES, q=TRACES.q * 0.0 + 0.0125 * np.pi))
    assert own is not None
    assert own.label == "Position within a wave [waves]"
    assert own.values == pytest.approx(0.625)


@pytest.mark.parametrize(
    "one",
    [
        effect("inertial_coupling", coupling_source=3.0),
        effect("torque_crosstalk", crosstalk_after=0.1),
        effect("gravity_error", gravity_error_source=-1.0),
    ],
    ids=lambda one: one.name,
)
def test_what_follows_other_joints_is_drawn_along_its_torque(one: Effect) -> None:
    own = own_axis(one, TRACES)
    assert own is not None
    assert own.label == f"{one.name}, fitted [N m]"
    assert own.values is TORQUE
