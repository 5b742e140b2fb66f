"""Load, gravity, neighbours and direction: each explains its own torque, and says what it lacks."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.discrepancy.candidates import (
    gravity_error,
    inertia_error,
    inertial_coupling,
    load_dependent_friction,
    torque_crosstalk,
    unlogged_compensation,
)
from friction_audit.joint_log import Float
from friction_audit.model.rigid_body import RigidBody
from friction_audit.model.terms.inertial_coupling import AFTER, ALL, BEFORE, BOTH
from tests.discrepancy.candidates.explained import share_explained
from tests.discrepancy.candidates.joint_data_by_hand import baseline, two_sines

PLAIN = two_sines()
LOADED = replace(PLAIN, load=8.0 * np.sin(PLAIN.q + 0.4))
TRANSMITTED = LOADED.load + baseline(LOADED).torque if LOADED.load is not None else np.zeros(0)
LOADS = {
    "linear": np.sign(PLAIN.dq) * np.abs(TRANSMITTED),
    "squared": np.sign(PLAIN.dq) * TRANSMITTED**2,
    "against the load": np.sign(PLAIN.dq) * np.abs(TRANSMITTED) * (1.0 + 0.4 * np.sign(TRANSMITTED * PLAIN.dq)),
}


@pytest.mark.parametrize("form", LOADS)
def test_loads(form: str) -> None:
    torque: Float = 0.02 * LOADS[form]
    assert share_explained(load_dependent_friction.CANDIDATE, LOADED, torque) > 0.99
    assert share_explained(load_dependent_friction.CANDIDATE, LOADED, -torque) < 0.5


def test_an_unknown_or_a_steady_load_says_so() -> None:
    assert "not known" in str(load_dependent_friction.CANDIDATE.untestable(PLAIN, baseline(PLAIN)))
    steady = replace(PLAIN, load=np.full(len(PLAIN.t), 5.0))
    assert "from 5 to 5 N m" in str(load_dependent_friction.CANDIDATE.untestable(steady, baseline(steady)))
    heavy = replace(PLAIN, load=10.0 + 2.0 * np.sin(PLAIN.q))
    assert load_dependent_friction.CANDIDATE.untestable(heavy, baseline(heavy)) is None
    assert load_dependent_friction.CANDIDATE.untestable(LOADED, baseline(LOADED)) is None


def test_gravity_of_a_link_is_told_from_the_joint_s_own_angle() -> None:
    pulls = np.zeros((len(PLAIN.t), 1, 4))
    pulls[:, 0, 0] = np.cos(PLAIN.q + 1.3 * np.sin(0.7 * PLAIN.t))
    body = RigidBody(t=PLAIN.t, links=(2,), weight=pulls, tilt=np.zeros((len(PLAIN.t), 2)), inertial=None, tip=None)
    torque = 0.3 * pulls[:, 0, 0]
    assert share_explained(gravity_error.CANDIDATE, replace(PLAIN, rigid=body), torque) > 0.99
    assert share_explained(gravity_error.CANDIDATE, PLAIN, torque) < 0.8


def test_a_neighbour_s_reading_and_its_acceleration_are_two_things() -> None:
    reading, shaking = 0.05 * PLAIN.others_torque[:, 2], 0.05 * PLAIN.others_ddq[:, 0]
    assert share_explained(torque_crosstalk.CANDIDATE, PLAIN, reading) > 0.99
    assert share_explained(torque_crosstalk.CANDIDATE, PLAIN, shaking) < 0.1
    assert share_explained(inertial_coupling.CANDIDATE, PLAIN, shaking) > 0.99
    assert share_explained(inertial_coupling.CANDIDATE, PLAIN, reading) < 0.1


def test_joints_at_the_ends_of_an_arm_try_the_neighbour_that_there_is() -> None:
    first, last = replace(PLAIN, others_joint=0), replace(PLAIN, others_joint=2)
    assert [shape["crosstalk_side"] for shape in torque_crosstalk.CANDIDATE.tried(first)] == [1.0]
    assert [shape["crosstalk_side"] for shape in torque_crosstalk.CANDIDATE.tried(last)] == [-1.0]


def test_couplings_with_many_factors_take_many_cycles() -> None:
    tried = [shape["coupling_source"] for shape in inertial_coupling.CANDIDATE.tried(PLAIN)]
    assert tried == [BEFORE, AFTER, BOTH, ALL]
    few = replace(PLAIN, cycle=np.minimum(PLAIN.cycle, 6))
    assert [shape["coupling_source"] for shape in inertial_coupling.CANDIDATE.tried(few)] == [BEFORE, AFTER, BOTH]


def test_what_needs_stated_numbers_names_them() -> None:
    assert "inertia_kg_m2" in str(inertia_error.CANDIDATE.untestable(PLAIN, baseline(PLAIN)))
    assert 'held = ["coulomb"]' in str(unlogged_compensation.CANDIDATE.untestable(PLAIN, baseline(PLAIN)))
    held = replace(baseline(PLAIN), declared=frozenset({"inertia_kg_m2", "coulomb_nm"}))
    assert inertia_error.CANDIDATE.untestable(PLAIN, held) is None
    assert unlogged_compensation.CANDIDATE.untestable(PLAIN, held) is None


def test_a_compensator_helps_and_what_resists_is_none() -> None:
    helps: Float = -0.2 * np.tanh(PLAIN.dq / 0.2)
    assert share_explained(unlogged_compensation.CANDIDATE, PLAIN, helps) > 0.99
    assert share_explained(unlogged_compensation.CANDIDATE, PLAIN, -helps) < 0.1
