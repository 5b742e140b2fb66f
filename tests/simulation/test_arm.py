"""A whole arm: who guides it, compensators in its joints, and what an audit makes of its log."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.compensation.competitors import FixedCompensation
from friction_audit.compensation.law import EnergyCompensator
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float, JointLog
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.presets import PRESETS
from friction_audit.robot.arm import load_arm
from friction_audit.simulation import EFFECTS, IDEAL_SENSORS, ArmSettings, Hidden, JointParameters, TrueMotion, simulate
from friction_audit.simulation.bench import PANDA_JOINTS
from friction_audit.simulation.effects.load_and_place import GravityError
from friction_audit.simulation.effects.structure import Backlash, JointElasticity
from friction_audit.simulation.periodic import multisine
from friction_audit.simulation.settings import make_streams
from tests.each_case import thorough, with_thorough
from tests.simulation.test_arm_dynamics import flange_poses, intended

# A hand that guides the arm: where it goes, which joints follow, where it rests, what it carries.

IDEAL = (IDEAL_SENSORS,) * 7
GUIDED = ArmSettings(sensors=IDEAL, duration_s=12.0)
SHORT = replace(GUIDED, duration_s=2.0)
PANDA = PRESETS["panda"]
SEED = 2


once = cache(simulate)


@pytest.mark.parametrize("seed", [0, 2, *thorough([1, *range(3, 20)])])
def test_motion_keeps_the_limits_of_a_panda(seed: int) -> None:
    motion = once(SHORT, seed).truth.motion
    assert (motion.q > np.array(PANDA.low_rad) + 0.1).all()
    assert (motion.q < np.array(PANDA.high_rad) - 0.1).all()
    assert (np.abs(motion.dq) < 0.95 * np.array(PANDA.speed_rad_s)).all()


def test_hand_comes_to_rest_in_every_pause() -> None:
    motion = simulate(GUIDED, SEED).truth.motion
    path = intended(GUIDED, SEED, len(motion.t) - 1)
    speed = load_arm().hand_speed(motion.q, motion.dq)
    paused = ~(path.velocity.any(axis=1) | path.angular.any(axis=1))
    ends = np.flatnonzero(np.diff(paused.astype(int)) == -1)
    assert len(ends) > 4
    assert (speed[ends] < 0.025).all()
    assert speed.max() > 0.2


def test_brakes_hold_their_joints_and_the_others_move() -> None:
    braked = replace(SHORT, braked=(3, 5), hidden=(Hidden(gravity_error=GravityError(torque_nm=0.2)),) * 7)
    simulation = simulate(braked, SEED)
    motion = simulation.truth.motion
    assert braked.moving == (1, 2, 4, 6, 7)
    assert_array_equal(motion.dq[:, [2, 4]], 0.0)
    assert_array_equal(motion.q[:, [2, 4]], np.array(braked.pose_rad)[[2, 4]] * np.ones((len(motion.t), 1)))
    assert (np.ptp(motion.q, axis=0)[[0, 1, 3, 5, 6]] > 0.01).all()
    assert np.ptp(simulation.log.channels()["tau_J"][:, 2]) > 0.5


def test_an_unknown_load_sags_and_gravity_compensation_stays_the_controllers() -> None:
    carrying, arm = simulate(replace(SHORT, carried_kg=2.0), SEED), load_arm()
    motion, plain = carrying.truth.motion, once(SHORT, SEED).truth.motion
    assert_allclose(carrying.log.channels()["gravity"], arm.gravity(motion.q), atol=1e-4)
    now, before = (flange_poses(arm, one.q[499:500])[0][0, 2] for one in (motion, plain))
    weight_on_the_spring = 2.0 * 9.81 / GUIDED.hand.stiffness_n_per_m
    assert -weight_on_the_spring * 1.02 < now - before < -0.7 * weight_on_the_spring


# Friction compensators in every joint of a guided arm.

JOINT = JointParameters(inertia_kg_m2=0.2, coulomb_nm=0.3, viscous_nms_per_rad=0.06)
ALONE = ArmSettings(joints=(JOINT,) * 7, sensors=(IDEAL_SENSORS,) * 7, duration_s=12.0)
TRUE_VALUES = FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.06)
HELPED_SEED = 1
LATER_S = 9.0


def power(motion: TrueMotion, since_s: float = 0.0) -> float:
    """Return the mean power that the person spends on the motors and their friction. [W]"""
    late = motion.t >= since_s
    return float((motion.interaction_nm * motion.inner_dq)[late].sum(axis=1).mean())


def effort(motion: TrueMotion, since_s: float = 0.0) -> float:
    """Return the root mean square of the interaction torques. [N m]"""
    return float(np.sqrt((motion.interaction_nm[motion.t >= since_s] ** 2).mean()))


def test_true_coefficients_take_friction_off_the_hand() -> None:
    helped = simulate(replace(ALONE, compensator=TRUE_VALUES, duration_s=6.0), HELPED_SEED)
    motion, alone = helped.truth.motion, once(ALONE, HELPED_SEED).truth.motion
    assert power(motion) < 0.1 * power(alone)
    assert effort(motion) < 0.9 * effort(alone)
    driving = motion.interaction_nm + motion.compensation_nm - motion.friction_nm
    assert_allclose(0.2 * motion.inner_ddq, driving, atol=1e-12)
    log = helped.log.channels()
    assert_array_equal(log["tau_J_d"], log["tau_compensation"])
    dq, torque = log["dq"][:-1], log["tau_compensation"][1:]
    fast = np.abs(dq) > 0.02
    assert_allclose(torque[fast], (0.3 * np.sign(dq) + 0.06 * dq)[fast], atol=1e-12)
    assert_array_equal(torque[~fast], 0.0)


def test_learning_compensators_take_friction_off_the_hand_which_ends_their_cycles() -> None:
    helped = simulate(replace(ALONE, compensator=EnergyCompensator()), HELPED_SEED)
    before, after = once(ALONE, HELPED_SEED).truth.motion, helped.truth.motion
    known = helped.truth.compensators
    ended = np.diff(known["cycle"], axis=0) != 0
    assert_array_equal(ended.any(axis=1), ended.all(axis=1))
    assert ended.any()
    assert power(after, LATER_S) < 0.2 * power(before, LATER_S)
    assert effort(after, LATER_S) < effort(before, LATER_S)
    assert np.ptp(known["energy_j"].sum(axis=1)[after.t >= LATER_S]) < 0.2 * before.dissipated_j[-1].sum()
    assert_array_equal(helped.log.channels()["tau_passivity"].shape, after.q.shape)


# One compensator for each joint of an arm.

ONE = FixedCompensation(coulomb_nm=0.2, viscous_nms_per_rad=0.03)
EACH_SHORT = ArmSettings(duration_s=2.0)


def test_every_joint_has_its_own() -> None:
    own = tuple(replace(ONE, coulomb_nm=0.0, viscous_nms_per_rad=0.01 * joint) for joint in range(7))
    motion = simulate(replace(EACH_SHORT, compensator=own), 0).truth.motion
    largest = np.abs(motion.compensation_nm).max(axis=0)
    assert largest[0] == 0.0
    assert (largest[1:] > 0.0).all()
    with pytest.raises(UsageError, match="2 compensators: expected one, or 7"):
        simulate(replace(EACH_SHORT, compensator=(ONE, ONE)), 0)


# What the audit makes of an arm's log.

COULOMB = np.array([joint.coulomb_nm for joint in PANDA_JOINTS])
DRIVEN = ArmSettings(driven=True, duration_s=10.0)
AUDITED_SEED = 3


def coulomb(estimate: Estimate) -> Float:
    return np.array([joint.coulomb.value for joint in estimate.friction.joints])


def test_a_driven_arm_follows_its_command_and_its_friction_is_found() -> None:
    driven = simulate(DRIVEN, AUDITED_SEED)
    motion = driven.truth.motion
    command = multisine(DRIVEN.servo.motion, 7, len(motion.t) - 1, 1e-3, make_streams(AUDITED_SEED, 7).person)
    assert np.abs(motion.q - command.position - np.array(DRIVEN.pose_rad)).max() < 0.03
    assert (np.ptp(motion.q, axis=0) > 0.3).all()
    settings = AuditSettings(torque=TorqueSettings(drive="robot", robot="panda"))
    assert np.abs(coulomb(estimate_log(driven.log, settings)) - COULOMB).max() < 0.03


@pytest.mark.thorough
def test_friction_of_a_guided_arm_is_found_with_default_settings() -> None:
    simulation = simulate(ArmSettings(duration_s=20.0), AUDITED_SEED)
    estimate = estimate_log(simulation.log, AuditSettings())
    assert np.abs(coulomb(estimate) - COULOMB)[1:].max() < 0.03
    truths = [
        (joint.coulomb, true.coulomb_nm) for joint, true in zip(estimate.friction.joints, PANDA_JOINTS, strict=True)
    ]
    assert sum(found.low <= truth <= found.high for found, truth in truths) >= 5


# Every hidden effect in joints 2 and 5 of an arm.

EFFECTS_SHORT = ArmSettings(duration_s=2.0)
OFF: list[tuple[Any, dict[str, Any]]] = [(effect.make({}), {effect.strength_name: 0.0}) for effect in EFFECTS]
NOTHING_YET = Hidden().holding(*(replace(group, **off) for group, off in OFF))
EFFECTS_SEED = 1


def log_of(hidden: Hidden, driven: bool) -> JointLog:
    among_others = tuple(hidden if joint in (2, 5) else Hidden() for joint in range(1, 8))
    return once(replace(EFFECTS_SHORT, hidden=among_others, driven=driven), EFFECTS_SEED).log


@pytest.mark.parametrize("driven", [False, True], ids=["guided", "driven"])
def test_all_effects_at_zero_strength_change_nothing_to_the_bit(driven: bool) -> None:
    plain, hidden = (log_of(inside, driven) for inside in (Hidden(), NOTHING_YET))
    for name, channel in plain.channels().items():
        assert_array_equal(hidden.channels()[name], channel)


# What the other effects do to one joint, ``test_bench.py`` shows.
@pytest.mark.parametrize("effect", [effect for effect in EFFECTS if effect.needs_neighbours], ids=str)
def test_effect_between_joints_changes_the_log_and_keeps_it_finite(effect: Any) -> None:
    hidden = Hidden().holding(effect.make({}))
    plain, changed = (log_of(inside, False).channels() for inside in (Hidden(), hidden))
    for channel in changed.values():
        assert np.isfinite(channel).all()
        assert np.abs(channel).max() < 100.0
    assert any(not np.array_equal(changed[name][:, [1, 4]], plain[name][:, [1, 4]]) for name in plain)


SOFT, STIFF = JointElasticity(compliance_rad_per_nm=1e-3), JointElasticity(compliance_rad_per_nm=1e-4)


INSIDE = {
    "soft": Hidden(joint_elasticity=SOFT),
    "stiff": Hidden(joint_elasticity=STIFF),
    "undamped": Hidden(joint_elasticity=replace(STIFF, damping_ratio=0.0)),
    "backlash": Hidden(backlash=Backlash(gap_rad=2e-3)),
    "both": Hidden(joint_elasticity=STIFF, backlash=Backlash(gap_rad=2e-3)),
}


@pytest.mark.parametrize(("inside", "driven"), with_thorough([("soft", True), ("both", False)], INSIDE, (False, True)))
def test_transmissions_of_all_joints_stay_calm(inside: str, driven: bool) -> None:
    each = replace(EFFECTS_SHORT, sensors=IDEAL, driven=driven)
    both = (once(replace(each, hidden=(one,) * 7), EFFECTS_SEED) for one in (Hidden(), INSIDE[inside]))
    rigid, soft = (one.truth.motion for one in both)
    assert np.abs(soft.q - rigid.q).max() < 0.1
    assert np.abs(soft.inner_dq).max() < 1.5 * np.abs(rigid.inner_dq).max()
    assert np.abs(soft.interaction_nm).max() < 4.0 * np.abs(rigid.interaction_nm).max()
