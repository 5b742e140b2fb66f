"""What holds for every candidate, and by hand for some."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.discrepancy.candidate import Candidate
from friction_audit.discrepancy.candidates import CANDIDATES
from friction_audit.discrepancy.displacement import onsets, stop_operator, strokes
from friction_audit.joint_log import Float
from tests.discrepancy.candidates.joint_data_by_hand import at_rest, baseline, joint_data, two_sines

NAMES = [
    "stribeck",
    "stiction",
    "nonlinear_viscous",
    "asymmetric_coulomb",
    "asymmetric_viscous",
    "presliding",
    "frictional_lag",
    "load_dependent_friction",
    "position_dependent_friction",
    "torque_ripple",
    "gravity_error",
    "cable_spring",
    "joint_limit_stop",
    "torque_bias",
    "torque_drift",
    "time_delay",
    "torque_crosstalk",
    "joint_elasticity",
    "backlash",
    "inertia_error",
    "inertial_coupling",
    "warm_up",
    "friction_step",
    "contact_event",
    "unlogged_compensation",
]
ODD = {"stribeck", "stiction", "nonlinear_viscous", "presliding", "frictional_lag", "load_dependent_friction"} | {
    "position_dependent_friction", "backlash", "warm_up", "friction_step", "unlogged_compensation",
    "asymmetric_coulomb", "asymmetric_viscous", "inertia_error", "joint_elasticity", "time_delay",
}  # fmt: skip
MOVING = two_sines()
each = pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda c: c.name)
BY_NAME = {c.name: c for c in CANDIDATES}


def column(name: str, **shape: float) -> Float:
    return BY_NAME[name].columns(MOVING, baseline(MOVING), shape)


def test_names_are_the_vocabulary_in_its_order() -> None:
    assert [c.name for c in CANDIDATES] == NAMES


def test_what_is_the_same_says_so_both_ways() -> None:
    assert BY_NAME["torque_bias"].same_as == ("asymmetric_coulomb",)
    assert BY_NAME["asymmetric_coulomb"].same_as == ("torque_bias",)
    used = MOVING.used
    assert_array_equal(column("torque_bias")[used], column("asymmetric_coulomb")[used])


@each
def test_columns_are_finite_and_as_many_as_units(candidate: Candidate) -> None:
    for shape in candidate.shapes:
        columns = candidate.columns(MOVING, baseline(MOVING), shape)
        assert columns.ndim == 2
        assert len(columns) == len(MOVING.t)
        assert np.all(np.isfinite(columns))
        if candidate.name != "inertial_coupling":  # as many as other joints, all in one unit
            assert columns.shape[1] == len(candidate.column_units)


@each
def test_no_candidate_reads_the_measured_torque(candidate: Candidate) -> None:
    other = replace(MOVING, torque=MOVING.torque + 1.0)
    for shape in candidate.shapes:
        assert_array_equal(
            candidate.columns(MOVING, baseline(MOVING), shape), candidate.columns(other, baseline(MOVING), shape)
        )


@each
def test_what_needs_motion_is_zero_at_rest(candidate: Candidate) -> None:
    rest = at_rest()
    for shape in candidate.shapes:
        columns = candidate.columns(rest, baseline(rest), shape)
        assert np.all(np.isfinite(columns))
        if candidate.name in ODD:
            assert_array_equal(columns, 0.0)


@each
def test_a_joint_at_rest_lacks_something_in_one_sentence(candidate: Candidate) -> None:
    rest = at_rest()
    rest = replace(rest, others_dq=np.zeros_like(rest.others_dq))
    said = candidate.untestable(rest, baseline(rest))
    assert said
    assert "\n" not in said


def test_declared_numbers_open_the_gates_of_what_needs_them() -> None:
    told = replace(baseline(MOVING), declared=frozenset({"inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad"}))
    for name in ("inertia_error", "unlogged_compensation"):
        assert "fitted" in str(BY_NAME[name].untestable(MOVING, baseline(MOVING)))
        assert BY_NAME[name].untestable(MOVING, told) is None


def test_columns_by_hand() -> None:
    v, q = MOVING.dq, MOVING.q
    s = np.clip(v / 0.01, -1, 1)
    assert_allclose(column("stribeck", speed_rad_s=0.1, exponent=2.0)[:, 0], s * np.exp(-((v / 0.1) ** 2)))
    assert_allclose(column("nonlinear_viscous", exponent=2.0)[:, 0], s * v**2)
    assert_allclose(column("gravity_error"), np.column_stack([np.cos(q), np.sin(q)]))
    assert_allclose(column("torque_crosstalk"), MOVING.others_torque[:, [0, 2]])


def test_stop_element_by_hand() -> None:
    q = np.array([0.0, 0.1, 0.3, 0.2, 0.0, -0.1])
    assert_allclose(stop_operator(q, 0.2), [0.0, 0.5, 1.0, 0.5, -0.5, -1.0])


def test_strokes_by_hand() -> None:
    dq = np.array([0.0, 1.0, 1.0, 0.001, -0.001, -1.0, -1.0, 0.0, 1.0])
    q = np.array([0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0, 1.0])
    cut = strokes(joint_data(q, dq, np.zeros(9)))
    assert_array_equal(cut.direction, [0, 1, 1, 1, -1, -1, -1, -1, 1])
    assert_array_equal(cut.reversals, [4, 8])
    assert_array_equal(cut.displacement, [0, 0, 1, 1, 0, -1, -2, -2, 0])


def test_onsets_come_after_rest() -> None:
    dq = np.concatenate([np.zeros(20), np.ones(20), np.zeros(5), np.ones(20), np.zeros(20), np.ones(5)])
    assert_array_equal(onsets(joint_data(np.zeros(90), dq, np.zeros(90))), [20, 85])
