"""What holds for every candidate, and by hand for the strokes that many lean on."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from friction_audit.diagnosis.candidate import Candidate
from friction_audit.diagnosis.candidates import CANDIDATES
from friction_audit.effects.joint_data import strokes
from tests.diagnosis.candidates.joint_data_by_hand import at_rest, baseline, joint_data, two_sines
from tests.diagnosis.started_and_stopped import started_and_stopped

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
AXES = {"speed", "position", "displacement", "time", "acceleration", "load", "neighbour"}
GRID_FROM_TORQUE = {"contact_event", "joint_elasticity"}
"""A touch is where the torque stands out; a spring that stiffens does so by the size of the torque on it."""
MOST_SHAPES = 200
"""A search tries all of them on every joint."""
MOVING = two_sines()
BASE = baseline(MOVING)
TOLD = replace(BASE, declared=frozenset({"inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad"}))
each = pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda c: c.name)
with_term = pytest.mark.parametrize("candidate", [c for c in CANDIDATES if c.term], ids=lambda c: c.name)
BY_NAME = {c.name: c for c in CANDIDATES}


def test_names_are_the_vocabulary_in_its_order() -> None:
    assert [c.name for c in CANDIDATES] == NAMES


@each
def test_it_says_where_it_shows_and_what_it_is(candidate: Candidate) -> None:
    assert candidate.axis in AXES
    assert candidate.label
    assert candidate.column_units
    for other in candidate.same_as:
        assert candidate.name in BY_NAME[other].same_as
        assert candidate.part_of == BY_NAME[other].part_of
    assert set(candidate.part_of) <= set(BY_NAME) - {candidate.name, *candidate.same_as}


@each
def test_what_a_log_shows_even_so_is_among_what_is_tried(candidate: Candidate) -> None:
    for data in (MOVING, started_and_stopped(starts=8)):
        tried = candidate.tried(data)
        assert all(shape in tried for shape in candidate.shown(data))


@each
def test_columns_are_finite_and_as_many_as_units(candidate: Candidate) -> None:
    tried = candidate.tried(MOVING)
    assert 1 <= len(tried) <= MOST_SHAPES
    for shape in tried:
        columns = candidate.columns(MOVING, BASE, shape)
        assert columns.ndim == 2
        assert len(columns) == len(MOVING.t)
        assert np.all(np.isfinite(columns))
        # As many as other joints, as touches, as links that are wrong.
        if candidate.name not in {"inertial_coupling", "contact_event", "gravity_error"}:
            assert columns.shape[1] == len(candidate.column_units)


@each
def test_shapes_are_all_different(candidate: Candidate) -> None:
    tried = [tuple(sorted(shape.items())) for shape in candidate.tried(MOVING)]
    assert len(set(tried)) == len(tried)


@each
def test_no_column_reads_the_measured_torque(candidate: Candidate) -> None:
    other = replace(MOVING, torque=MOVING.torque + 1.0)
    for shape in candidate.tried(MOVING):
        assert_array_equal(candidate.columns(MOVING, BASE, shape), candidate.columns(other, BASE, shape))


@pytest.mark.parametrize("candidate", [c for c in CANDIDATES if c.name not in GRID_FROM_TORQUE], ids=lambda c: c.name)
def test_no_grid_reads_the_measured_torque(candidate: Candidate) -> None:
    other = replace(MOVING, torque=np.cumsum(MOVING.torque))
    assert candidate.tried(other) == candidate.tried(MOVING)
    assert candidate.untestable(other, BASE) == candidate.untestable(MOVING, BASE)


@each
def test_what_needs_motion_is_zero_at_rest(candidate: Candidate) -> None:
    rest = at_rest()
    for shape in candidate.tried(rest):
        columns = candidate.columns(rest, baseline(rest), shape)
        assert np.all(np.isfinite(columns))
        if candidate.name in ODD:
            assert_array_equal(columns, 0.0)


@each
def test_factors_are_judged_by_sign_and_size(candidate: Candidate) -> None:
    for shape in candidate.tried(MOVING):
        width = candidate.columns(MOVING, BASE, shape).shape[1]
        assert type(candidate.admissible(np.full(width, 0.01), shape)) is bool
        assert not (candidate.column_units == ("s",) and candidate.admissible(np.full(width, 1e6), shape))


@with_term
def test_a_candidate_and_its_term_are_one(candidate: Candidate) -> None:
    term = candidate.term
    assert term is not None
    assert term.name == candidate.name
    names = {parameter.name for parameter in term.nonlinear if not parameter.optional}
    for shape in candidate.tried(MOVING):
        # Without a shape it is the term with a shape of zeros.
        assert not shape or names <= set(shape)
        for parameter in term.nonlinear if shape else ():
            assert parameter.allows(shape.get(parameter.name, 0.0)), (parameter.name, shape)


@with_term
def test_what_a_shape_leaves_loose_are_numbers_of_the_term(candidate: Candidate) -> None:
    assert candidate.term is not None
    names = {parameter.name for parameter in (*candidate.term.coefficients, *candidate.term.nonlinear)}
    for shape in candidate.tried(MOVING):
        for name, (least, most) in candidate.loose(shape).items():
            assert name in names
            assert 0.0 < least <= 1.0 <= most


@with_term
def test_what_is_admissible_a_model_can_hold(candidate: Candidate) -> None:
    term = candidate.term
    assert term is not None
    rng = np.random.default_rng(0)
    shape = candidate.tried(MOVING)[0]
    for factors in rng.normal(scale=0.02, size=(50, len(term.coefficients))):
        if candidate.admissible(factors, shape):
            assert all(parameter.allows(float(f)) for parameter, f in zip(term.coefficients, factors, strict=True)), (
                factors
            )


@each
def test_a_joint_at_rest_lacks_something_in_one_sentence(candidate: Candidate) -> None:
    rest = at_rest()
    rest = replace(rest, others_dq=np.zeros_like(rest.others_dq))
    said = candidate.untestable(rest, baseline(rest))
    assert said
    assert "\n" not in said


def test_declared_numbers_open_the_gates_of_what_needs_them() -> None:
    for name in ("inertia_error", "unlogged_compensation"):
        assert "fitted" in str(BY_NAME[name].untestable(MOVING, BASE))
        assert BY_NAME[name].untestable(MOVING, TOLD) is None


def test_strokes_by_hand() -> None:
    dq = np.array([0.0, 1.0, 1.0, 0.001, -0.001, -1.0, -1.0, 0.0, 1.0])
    q = np.array([0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0, 1.0])
    cut = strokes(joint_data(q, dq, np.zeros(9)))
    assert_array_equal(cut.direction, [0, 1, 1, 1, -1, -1, -1, -1, 1])
    assert_array_equal(cut.reversals, [4, 8])
    assert_array_equal(cut.displacement, [0, 0, 1, 1, 0, -1, -2, -2, 0])
