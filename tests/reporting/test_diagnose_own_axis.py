"""What an effect is drawn along: its own angle, one of its waves, or its own torque."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.result import Effect
from friction_audit.reporting.figures.diagnose_look import OwnAxis, own_axis, own_profile
from tests.reporting.diagnosis_by_hand import STRIBECK, coefficient, traces

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
    assert own.label == f"Fitted torque of {one.name} [N m]"
    assert own.values is TORQUE


def test_what_rings_is_drawn_along_its_torque() -> None:
    rows = np.arange(4800)
    motion = traces(1600)
    along = motion.along | {"speed": rows % 400 / 400.0}
    ringing = np.sin(0.77 * rows)
    own = own_axis(replace(STRIBECK, torque=ringing), replace(motion, dq=np.ones(4800), along=along))
    assert own is not None
    assert own.values is ringing


def test_means_along_an_own_axis_by_hand() -> None:
    motion = replace(traces(8), dq=np.tile([1.0, 1.0, -1.0], 8))
    own = OwnAxis("waves", np.repeat([0.0, 1.2], 12))
    shown = own_profile(own, motion, np.where(own.values > 0.6, 3.0, 1.0))
    assert shown.edges == pytest.approx(np.linspace(0.0, 1.2, 13))
    assert shown.forwards[[0, -1]] == pytest.approx([1.0, 3.0])
    assert np.isnan(shown.forwards[1:-1]).all()
    assert np.isnan(shown.backwards).all()  # of four rows, fewer than a mean is told from
