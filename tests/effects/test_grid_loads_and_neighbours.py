"""Load, gravity, neighbours and direction: each explains its own torque, and says what it lacks."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.dynamics.motion import RigidBody
from friction_audit.effects import (
    gravity_error,
    inertia_error,
    inertial_coupling,
    load_dependent_friction,
    torque_crosstalk,
    unlogged_compensation,
)
from friction_audit.effects.gravity_error import EFFECT as TERM
from friction_audit.effects.gravity_error import OWN_ANGLE, SEVERAL
from friction_audit.effects.inertial_coupling import AFTER, ALL, BEFORE, BOTH
from friction_audit.joint_log import Float
from tests.diagnosis.toy_effects import altered
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import baseline, two_sines

PLAIN = two_sines()
LOADED = replace(PLAIN, load=8.0 * np.sin(PLAIN.q + 0.4))
TRANSMITTED = LOADED.load + baseline(LOADED).torque if LOADED.load is not None else np.zeros(0)
WEIGHT = np.zeros(0) if LOADED.load is None else LOADED.load
LOADS = {
    "weight alone": np.sign(PLAIN.dq) * np.abs(WEIGHT),
    "linear": np.sign(PLAIN.dq) * np.abs(TRANSMITTED),
    "squared": np.sign(PLAIN.dq) * TRANSMITTED**2,
    "against the load": np.sign(PLAIN.dq) * np.abs(TRANSMITTED) * (1.0 + 0.4 * np.sign(TRANSMITTED * PLAIN.dq)),
}


@pytest.mark.parametrize("form", LOADS)
def test_loads(form: str) -> None:
    torque: Float = 0.02 * LOADS[form]
    assert share_explained(load_dependent_friction.EFFECT, LOADED, torque) > 0.999
    assert share_explained(load_dependent_friction.EFFECT, LOADED, -torque) < 0.5


def test_an_unknown_or_a_steady_load_says_so() -> None:
    assert "not known" in str(load_dependent_friction.EFFECT.not_identifiable(PLAIN, baseline(PLAIN)))
    steady = replace(PLAIN, load=np.full(len(PLAIN.t), 5.0))
    assert "from 5 to 5 N m" in str(load_dependent_friction.EFFECT.not_identifiable(steady, baseline(steady)))
    heavy = replace(PLAIN, load=10.0 + 2.0 * np.sin(PLAIN.q))
    assert load_dependent_friction.EFFECT.not_identifiable(heavy, baseline(heavy)) is None
    assert load_dependent_friction.EFFECT.not_identifiable(LOADED, baseline(LOADED)) is None


def test_gravity_of_a_link_is_told_from_the_joint_s_own_angle() -> None:
    pulls = np.zeros((len(PLAIN.t), 1, 4))
    pulls[:, 0, 0] = np.cos(PLAIN.q + 1.3 * np.sin(0.7 * PLAIN.t))
    body = RigidBody(t=PLAIN.t, links=(2,), weight=pulls, tilt=np.zeros((len(PLAIN.t), 2)), inertial=None, tip=None)
    torque = 0.3 * pulls[:, 0, 0]
    assert share_explained(gravity_error.EFFECT, replace(PLAIN, rigid=body), torque) > 0.99
    assert share_explained(gravity_error.EFFECT, PLAIN, torque) < 0.8


def an_arm(*weight: Float, links: tuple[int, ...] = (2, 3, 7)) -> RigidBody:
    """What a model says of a joint: weights of links, shape (n, 4) each."""
    tilt = np.zeros((len(PLAIN.t), 2))
    return RigidBody(t=PLAIN.t, links=links, weight=np.stack(weight, axis=1), tilt=tilt, inertial=None, tip=None)


def four(*columns: Float) -> Float:
    """Columns of a link, zeros behind them."""
    return np.column_stack([*columns, *([np.zeros(len(PLAIN.t))] * (4 - len(columns)))])


ONE, TWO, THREE = PLAIN.q, PLAIN.q + 1.3 * np.sin(0.7 * PLAIN.t), PLAIN.q - 0.9 * np.sin(1.1 * PLAIN.t)
OWN, NEXT, LAST = (9.81 * four(np.cos(angle), np.sin(angle)) for angle in (ONE, TWO, THREE))
SEVERAL_LINKS = {"gravity_error_source": float(SEVERAL)}


def test_two_links_that_are_wrong_at_once_are_told_with_their_numbers() -> None:
    data = replace(PLAIN, rigid=an_arm(OWN, NEXT, LAST))
    torque = NEXT @ [0.03, 0.0, 0.0, 0.0] + LAST @ [0.02, -0.04, 0.0, 0.0]
    assert SEVERAL_LINKS in gravity_error.EFFECT.grid(data)
    columns = gravity_error.EFFECT.regressor(data, baseline(data), SEVERAL_LINKS)
    factors = np.linalg.lstsq(columns, torque)[0]
    told = {p.name: f for p, f in zip(TERM.coefficients, factors, strict=True) if abs(f) > 1e-9}
    names = ["next_link_moment_x_kg_m", "last_link_moment_x_kg_m", "last_link_moment_y_kg_m"]
    assert told == pytest.approx(dict(zip(names, [0.03, 0.02, -0.04], strict=True)))
    one_by_one = altered(
        gravity_error.EFFECT, grid=tuple(s for s in gravity_error.EFFECT.grid(data) if s != SEVERAL_LINKS)
    )
    assert share_explained(gravity_error.EFFECT, data, torque) > 0.999
    assert share_explained(one_by_one, data, torque) < 0.9


def test_columns_that_depend_on_others_are_left_out() -> None:
    nearly = OWN[:, 0] + 1e-3 * LAST[:, 0]
    data = replace(PLAIN, rigid=an_arm(OWN, four(OWN[:, 1], nearly, NEXT[:, 0]), LAST))
    told = gravity_error.independent(data)
    columns = gravity_error.EFFECT.regressor(data, baseline(data), SEVERAL_LINKS)
    assert np.count_nonzero(told) == np.count_nonzero(columns.any(axis=0)) == 5
    assert told[[6, 8, 9]].all()
    assert told[0] != told[5]
    assert told[1] != told[4]
    left = columns[:, columns.any(axis=0)]
    assert np.linalg.cond(left) < 100.0
    explained = left @ np.linalg.lstsq(left, OWN)[0]
    assert np.abs(explained - OWN).max() < 0.02 * 9.81


@pytest.mark.parametrize(
    "weight",
    [(OWN, four(OWN[:, 1]), four(OWN[:, 0])), (OWN, four(), four()), (1e-12 * OWN, 1e-12 * NEXT, 1e-12 * LAST)],
    ids=["the same weight three times", "one link", "rounding"],
)
def test_what_pulls_like_one_link_is_not_several(weight: tuple[Float, Float, Float]) -> None:
    data = replace(PLAIN, rigid=an_arm(*weight))
    assert SEVERAL_LINKS not in gravity_error.EFFECT.grid(data)


def test_without_a_model_of_the_arm_there_is_the_joint_s_own_angle_alone() -> None:
    assert gravity_error.EFFECT.grid(PLAIN) == ({"gravity_error_source": float(OWN_ANGLE)},)
    assert gravity_error.EFFECT.regressor(PLAIN, baseline(PLAIN), {"gravity_error_source": 0.0}).shape[1] == 8


def test_masses_that_no_arm_carries_are_not_believed_of_several_links() -> None:
    factors = np.array([0.0] * 5 + [12.0] + [0.0] * 10)
    assert not gravity_error.EFFECT.admissible(factors, SEVERAL_LINKS)
    assert gravity_error.EFFECT.admissible(factors / 12.0, SEVERAL_LINKS)


def test_a_neighbour_s_reading_and_its_acceleration_are_two_things() -> None:
    reading, shaking = 0.05 * PLAIN.others_torque[:, 2], 0.05 * PLAIN.others_ddq[:, 0]
    assert share_explained(torque_crosstalk.EFFECT, PLAIN, reading) > 0.99
    assert share_explained(torque_crosstalk.EFFECT, PLAIN, shaking) < 0.1
    assert share_explained(inertial_coupling.EFFECT, PLAIN, shaking) > 0.99
    assert share_explained(inertial_coupling.EFFECT, PLAIN, reading) < 0.1


def test_joints_at_the_ends_of_an_arm_try_the_neighbour_that_there_is() -> None:
    first, last = replace(PLAIN, others_joint=0), replace(PLAIN, others_joint=2)
    assert [shape["crosstalk_side"] for shape in torque_crosstalk.EFFECT.grid(first)] == [1.0]
    assert [shape["crosstalk_side"] for shape in torque_crosstalk.EFFECT.grid(last)] == [-1.0]


def test_couplings_with_many_factors_take_many_cycles() -> None:
    tried = [shape["coupling_source"] for shape in inertial_coupling.EFFECT.grid(PLAIN)]
    assert tried == [BEFORE, AFTER, BOTH, ALL]
    few = replace(PLAIN, cycle=np.minimum(PLAIN.cycle, 6))
    assert [shape["coupling_source"] for shape in inertial_coupling.EFFECT.grid(few)] == [BEFORE, AFTER, BOTH]


def test_what_needs_stated_numbers_names_them() -> None:
    assert "inertia_kg_m2" in str(inertia_error.EFFECT.not_identifiable(PLAIN, baseline(PLAIN)))
    assert 'held = ["coulomb"]' in str(unlogged_compensation.EFFECT.not_identifiable(PLAIN, baseline(PLAIN)))
    held = replace(baseline(PLAIN), declared=frozenset({"inertia_kg_m2", "coulomb_nm"}))
    assert inertia_error.EFFECT.not_identifiable(PLAIN, held) is None
    assert unlogged_compensation.EFFECT.not_identifiable(PLAIN, held) is None


def test_a_compensator_helps_and_what_resists_is_none() -> None:
    helps: Float = -0.2 * np.tanh(PLAIN.dq / 0.2)
    assert share_explained(unlogged_compensation.EFFECT, PLAIN, helps) > 0.99
    assert share_explained(unlogged_compensation.EFFECT, PLAIN, -helps) < 0.1
