"""The axis along which an effect is drawn."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.diagnosis.profiles import own_axis, shows_along
from friction_audit.diagnosis.result import NamedEffect
from friction_audit.joint_log import Float
from tests.reporting.diagnosis_by_hand import STRIBECK, coefficient, traces

TRACES = traces(4)
TORQUE = np.linspace(-0.1, 0.2, len(TRACES.t))


def effect(name: str, **parameters: float) -> NamedEffect:
    numbers = {key: coefficient(value, 0.0) for key, value in parameters.items()}
    return replace(STRIBECK, name=name, parameters=numbers, torque=TORQUE)


def test_a_curve_over_the_joint_s_own_motion_needs_no_axis_of_its_own() -> None:
    assert own_axis(effect("stribeck", stribeck_excess_nm=0.1), TRACES) is None
    assert own_axis(effect("gravity_error", gravity_error_source=0.0), TRACES) is None


def test_waves_are_laid_over_each_other() -> None:
    own: Any = own_axis(effect("torque_ripple", ripple_order=100.0), replace(TRACES, q=TRACES.q * 0.0 + 0.0125 * np.pi))
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
def test_an_effect_of_other_joints_is_drawn_along_its_torque(one: NamedEffect) -> None:
    own: Any = own_axis(one, TRACES)
    assert own.label == f"Fitted torque of {one.name} [N m]"
    assert own.values is TORQUE


def test_ringing_is_drawn_along_its_torque_and_its_means_are_those_of_the_samples() -> None:
    rows = np.arange(4800)
    motion = traces(1600)
    along = motion.along | {"speed": rows % 400 / 400.0}
    ringing = np.sin(0.77 * rows)
    motion = replace(motion, dq=np.where(rows % 2, 1.0, -1.0), along=along, after=motion.measured - 0.5)
    own: Any = own_axis(replace(STRIBECK, torque=ringing), motion)
    assert own.values is ringing
    assert own.after.edges == pytest.approx(np.linspace(ringing.min(), ringing.max(), 13))
    assert own.after.forwards == pytest.approx(0.5)
    assert own.curve.backwards == pytest.approx(0.5 + own.curve.centre, abs=0.05)


PLACE, WAY, RINGING = np.tile(np.linspace(0.0, 1.0, 600), 8), np.repeat([1.0, -1.0] * 4, 600), np.sin(np.arange(4800))


@pytest.mark.parametrize(
    ("torque", "shown"),
    [
        (np.full(4800, 0.1), True),
        (WAY * np.exp(-PLACE / 0.1), True),
        (np.sin(400.0 * PLACE), False),
        (np.repeat([1.0, 1.0, -1.0, -1.0] * 2, 600), False),
        (1.1 + np.sqrt(2.0) * RINGING, True),
        (0.9 + np.sqrt(2.0) * RINGING, False),
    ],
    ids=["an offset", "fading", "fine waves", "now this way, now that way", "over half of it", "less than half"],
)
def test_a_place_is_given_where_most_of_the_torque_is_a_curve_over_the_axis(torque: Float, shown: bool) -> None:
    assert shows_along(torque, PLACE, WAY) is shown
