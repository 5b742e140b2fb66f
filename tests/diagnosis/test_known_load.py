"""What a model of the arm tells of the load, against the arm's own dynamics."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.diagnosis.diagnose import diagnose_joint
from friction_audit.diagnosis.known_load import know_load, known_inertias
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import least_squares
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.dynamics.motion import Others
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.registry import GRAVITY, effects
from friction_audit.joint_log import Float
from friction_audit.robot.arm import load_arm
from friction_audit.robot.unknown_chain import ChainMotion, chain_columns
from tests.effects.joint_data_by_hand import joint_of, sines
from tests.synthetic_interaction import choice

ARM = load_arm()
T: Float = np.arange(0.0, 2.0, 0.0025)
PHASE: Float = np.arange(7.0)
POSE: Float = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
Q = POSE + 0.3 * np.sin(2 * T[:, None] + PHASE)
DQ, DDQ = 0.6 * np.cos(2 * T[:, None] + PHASE), -1.2 * np.sin(2 * T[:, None] + PHASE)
ROBOT = replace(choice(gravity="model"), source="tau_J", drive="robot", inertia="model")
HAND = replace(choice(gravity="logged"), source="tau_J", sign=-1)


MOTION = Q, DQ, DDQ
CHAIN_T: Float = np.arange(0.0, 90.0, 0.005)


def test_gravity_and_inertia_of_a_driven_arm() -> None:
    known = know_load(ROBOT, ARM, T, MOTION, np.ones_like(Q))
    assert known.load == pytest.approx(ARM.inverse_dynamics(Q, DQ, DDQ), abs=1e-3)
    assert known.removed is known.load
    without = know_load(replace(ROBOT, gravity="none"), ARM, T, MOTION, None)
    assert without.removed == pytest.approx(ARM.inverse_dynamics(Q, DQ, DDQ) - ARM.gravity(Q), abs=1e-3)


def test_a_guided_arm_bears_gravity_alone_and_logged_gravity_is_preferred() -> None:
    logged = np.ones_like(Q)
    found: Any = know_load(HAND, ARM, T, MOTION, logged)
    load, removed, rigid = found
    assert load == pytest.approx(-logged)
    assert removed is None
    assert rigid[3].inertial is None
    assert rigid[3].tip is None
    assert know_load(HAND, ARM, T, MOTION, None).load == pytest.approx(-ARM.gravity(Q), abs=1e-3)


def test_without_a_model_nothing_is_known_but_what_was_logged() -> None:
    assert know_load(HAND, None, T, MOTION, None) == (None, None, None)
    assert know_load(HAND, None, T, MOTION, np.ones_like(Q)).load == pytest.approx(-np.ones_like(Q))


def test_a_heavier_tip_pulls_by_its_weight_and_where_motors_move_it_by_its_inertia() -> None:
    # A mass at the origin of joint 7, 0.107 m behind the flange, has no moment of inertia of its own.
    heavier = load_arm(payload=(0.5, 0.0, 0.0, -0.107))
    weight = heavier.gravity(Q) - ARM.gravity(Q)
    extra = heavier.inverse_dynamics(Q, DQ, DDQ) - ARM.inverse_dynamics(Q, DQ, DDQ)
    rigid: Any = [know_load(choice, ARM, T, MOTION, None).rigid for choice in (HAND, ROBOT)]
    guided, driven = rigid
    for joint in (1, 3):
        assert guided[joint].weight[:, -1, 3] == pytest.approx(-weight[::2, joint] / 0.5, abs=1e-6)
        assert driven[joint].weight[:, -1, 3] == pytest.approx(extra[::2, joint] / 0.5, abs=1e-6)
        assert np.abs(extra - weight)[:, joint].max() > 0.01


def test_inertia_that_a_model_removed_is_the_mean_diagonal_of_the_mass_matrix() -> None:
    q = np.tile(POSE, (10, 1))
    q[5:] += 0.4
    assert known_inertias(ARM, ROBOT, q) == pytest.approx(ARM.mass_diagonal(q).mean(axis=0))
    assert not known_inertias(ARM, replace(ROBOT, inertia="none"), q).any()
    assert not known_inertias(None, ROBOT, q).any()


def _second_joint(hidden: Float) -> JointData:
    """Joint 2 of the arm, all joints of which follow sines, without a model; hidden friction, shape (n,). [N m]"""
    rng, t = np.random.default_rng(0), CHAIN_T
    drawn = zip(rng.uniform(0.1, 0.3, 21), rng.uniform(0.5, 3.0, 21), rng.uniform(0.0, 6.0, 21), strict=True)
    moved = [sines(t, *three) for three in zip(drawn, drawn, drawn, strict=True)]
    q, dq, ddq = (np.column_stack(one) for one in zip(*moved, strict=True))
    q += POSE
    rigid = ARM.inverse_dynamics(q, dq, ddq)[:, 1]
    torque = rigid + (3.0 + hidden) * np.sign(dq[:, 1]) + 2.0 * dq[:, 1] + rng.normal(scale=0.05, size=len(t))
    others = Others(joint=1, q=q, dq=dq, ddq=ddq, sensed=0.0 * q)
    return joint_of(t, q[:, 1], dq[:, 1], ddq[:, 1], torque, others=others, weighs=True, unknown_gravity=True)


def test_without_a_model_the_dynamics_of_the_chain_leave_the_friction_of_a_joint() -> None:
    data = _second_joint(0.0 * CHAIN_T)
    problem = RegressionProblem.build(data, None)
    gravity = ARM.gravity(data.others.q)[:, 1]
    assert np.std(np.asarray(problem.data.load) - gravity) < 0.1 * np.std(gravity)
    own = np.column_stack([np.cos(data.q), np.sin(data.q), data.others.ddq, data.others.dq**2])  # effects of their own
    assert least_squares(np.vstack([problem.X, problem.columns(own)]), problem.y)[0] == pytest.approx(3.0, rel=0.03)
    # Projected out, the chain leaves little of viscous friction, as smooth as its torque; as noise it leaves enough.
    whole = problem.with_chain
    assert whole is not None
    motion = ChainMotion.of(1, *(whole.samples.of(one) for one in (data.others.q, data.others.dq, data.others.ddq)))
    _, size, basis = np.linalg.svd(chain_columns(motion, np.ones(len(whole.y)), whole.X, whole.y), full_matrices=False)
    rows = np.vstack([whole.X, whole.columns(own), whole.y])
    rows -= (rows @ basis.T * (1.0 - 1.0 / np.hypot(1.0, size))) @ basis
    found = least_squares(rows[:-1], rows[-1])
    assert (found[0], found[1]) == (pytest.approx(3.0, rel=0.03), pytest.approx(2.0, rel=0.1))


def test_without_a_model_an_effect_has_its_whole_size_and_nothing_else_a_name() -> None:
    subject = Subject(
        data=_second_joint(np.where(CHAIN_T > 45.0, 1.0, 0.0)), number=2, name="joint2", findings=(), from_energy={}
    )
    found = diagnose_joint(subject, effects(), DiagnosisSettings(), simulated=False)
    named = {one.name: one for one in found.effects if one.name not in (GRAVITY, "inertial_coupling")}
    assert list(named) == ["friction_step"]
    # Half of the time 1 N m, of which Coulomb friction may be the mean; the chain takes most of its mean square.
    assert named["friction_step"].size_nm == pytest.approx(0.5, rel=0.1)
