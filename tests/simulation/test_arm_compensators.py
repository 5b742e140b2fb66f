"""Friction compensators in every joint of a guided arm."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.compensation.compensators import EnergyCompensator, FixedCompensation
from friction_audit.simulation import IDEAL_SENSORS, ArmSettings, JointParameters, Simulation, TrueMotion, simulate

JOINT = JointParameters(inertia_kg_m2=0.2, coulomb_nm=0.3, viscous_nms_per_rad=0.06)
ALONE = ArmSettings(joints=(JOINT,) * 7, sensors=(IDEAL_SENSORS,) * 7, duration_s=14.0)
TRUE_VALUES = FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.06)
SEED = 1
LATER_S = 9.0


@pytest.fixture(scope="module")
def alone() -> Simulation:
    return simulate(ALONE, SEED)


@pytest.fixture(scope="module")
def told_by_the_hand() -> Simulation:
    return simulate(replace(ALONE, compensator=EnergyCompensator()), SEED)


def power(motion: TrueMotion, since_s: float = 0.0) -> float:
    """Return the mean power that the person spends on the motors and their friction. [W]"""
    late = motion.t >= since_s
    return float((motion.interaction_nm * motion.inner_dq)[late].sum(axis=1).mean())


def effort(motion: TrueMotion, since_s: float = 0.0) -> float:
    """Return the root mean square of the interaction torques. [N m]"""
    return float(np.sqrt((motion.interaction_nm[motion.t >= since_s] ** 2).mean()))


def test_true_coefficients_take_friction_off_the_hand(alone: Simulation) -> None:
    helped = simulate(replace(ALONE, compensator=TRUE_VALUES, duration_s=6.0), SEED)
    motion = helped.truth.motion
    assert power(motion) < 0.1 * power(alone.truth.motion)
    assert effort(motion) < 0.9 * effort(alone.truth.motion)
    assert_allclose(
        np.array(0.2) * motion.inner_ddq,
        motion.interaction_nm + motion.compensation_nm - motion.friction_nm,
        atol=1e-12,
    )
    log = helped.log.channels()
    assert_array_equal(log["tau_J_d"], log["tau_compensation"])
    dq, torque = log["dq"][:-1], log["tau_compensation"][1:]
    fast = np.abs(dq) > 0.02
    assert_allclose(torque[fast], (0.3 * np.sign(dq) + 0.06 * dq)[fast], atol=1e-12)
    assert_array_equal(torque[~fast], 0.0)


def test_hand_ends_the_cycles_of_all_joints_at_the_same_ticks(told_by_the_hand: Simulation) -> None:
    ended = np.diff(told_by_the_hand.truth.compensators["cycle"], axis=0) != 0
    assert_array_equal(ended.any(axis=1), ended.all(axis=1))
    assert ended.any()


def test_learning_compensators_take_friction_off_the_hand(alone: Simulation, told_by_the_hand: Simulation) -> None:
    before, after = alone.truth.motion, told_by_the_hand.truth.motion
    assert power(after, LATER_S) < 0.2 * power(before, LATER_S)
    assert effort(after, LATER_S) < effort(before, LATER_S)
    known = told_by_the_hand.truth.compensators
    energy = known["energy_j"].sum(axis=1)
    late = after.t >= LATER_S
    assert np.ptp(energy[late]) < 0.2 * alone.truth.motion.dissipated_j[-1].sum()
    assert_array_equal(told_by_the_hand.log.channels()["tau_passivity"].shape, after.q.shape)
