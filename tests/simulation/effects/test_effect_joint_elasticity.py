import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.errors import UsageError
from friction_audit.simulation.effects.joint_elasticity import (
    HARDENING,
    LINEAR,
    JointElasticity,
    damping_nms_per_rad,
    torque_nm,
)
from friction_audit.simulation.mechanics.records import pack


def test_linear_spring() -> None:
    record = pack([JointElasticity(compliance_rad_per_nm=1e-3)])[0]
    assert torque_nm(record, 2e-3) == pytest.approx(2.0)
    assert torque_nm(record, -2e-3) == pytest.approx(-2.0)


def test_hardening_spring_is_half_as_stiff_at_rest_and_as_stiff_far_away() -> None:
    record = pack([JointElasticity(compliance_rad_per_nm=1e-3, form=HARDENING)])[0]
    assert torque_nm(record, 1e-6) == pytest.approx(0.5e-3, rel=1e-6)
    assert torque_nm(record, 21e-3) - torque_nm(record, 20e-3) == pytest.approx(1.0, rel=1e-6)
    assert torque_nm(record, 2e-3) == pytest.approx(2.0 - math.tanh(1.0))


def test_usual_motor_rings_at_thirteen_hertz_in_the_hand() -> None:
    reduced, compliance = 0.15, JointElasticity.make({}).compliance_rad_per_nm
    assert math.sqrt(1 / (compliance * 0.3)) / (2 * math.pi) == pytest.approx(9.19, abs=0.01)
    assert math.sqrt(1 / (compliance * reduced)) / (2 * math.pi) == pytest.approx(12.99, abs=0.01)


def test_damping_gives_the_ratio() -> None:
    record = pack([JointElasticity(compliance_rad_per_nm=1e-3, damping_ratio=0.05)])[0]
    natural = math.sqrt(1e3 / 0.15)
    assert damping_nms_per_rad(record, 0.15) == pytest.approx(2 * 0.05 * natural * 0.15)


@given(stretch=st.floats(-0.05, 0.05), more=st.floats(1e-6, 0.01), form=st.sampled_from([LINEAR, HARDENING]))
def test_spring_is_odd_and_grows(stretch: float, more: float, form: int) -> None:
    record = pack([JointElasticity(compliance_rad_per_nm=1e-3, form=form)])[0]
    assert torque_nm(record, -stretch) == -torque_nm(record, stretch)
    assert torque_nm(record, stretch + more) > torque_nm(record, stretch)


@pytest.mark.parametrize("form", [LINEAR, HARDENING])
def test_rigid_joint_has_no_spring(form: int) -> None:
    record = pack([JointElasticity(form=form)])[0]
    assert torque_nm(record, 1e-3) == 0.0
    assert damping_nms_per_rad(record, 0.3) == 0.0


def test_a_gear_too_stiff_to_be_simulated_is_refused() -> None:
    with pytest.raises(UsageError, match="compliance_rad_per_nm 1e-09: expected 0, a rigid joint, or at least 1e-05"):
        JointElasticity(compliance_rad_per_nm=1e-9)
