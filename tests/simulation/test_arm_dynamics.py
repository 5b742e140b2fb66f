"""The arm against MuJoCo's own energies and inverse dynamics, and the hand's springs written once more."""

from dataclasses import fields, replace
from functools import cache, partial
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation

from friction_audit import simulation as sim
from friction_audit.joint_log import Float
from friction_audit.robot.arm import Arm, load_arm
from friction_audit.simulation.bench import PANDA_JOINTS
from friction_audit.simulation.settings import make_streams
from friction_audit.simulation.strokes import HandMotion, plan_hand

IDEAL = (sim.IDEAL_SENSORS,) * 7
ROTORS = np.array([joint.inertia_kg_m2 for joint in PANDA_JOINTS])
NOBODY = replace(sim.Hand(), **{item.name: 0.0 for item in fields(sim.Hand) if item.name != "path"})  # type: ignore[arg-type]
SMOOTH = tuple(replace(joint, coulomb_nm=0.0, viscous_nms_per_rad=0.0) for joint in PANDA_JOINTS)
SWING = sim.ArmSettings(sensors=IDEAL, hand=NOBODY, compensates_gravity=False, duration_s=1.0)
SEED = 1


def model_of(settings: sim.ArmSettings) -> Arm:
    """Return the arm with the hand's mass and the load at the flange."""
    held = settings.hand.mass_kg if not settings.driven else 0.0
    turning = np.eye(3) * (0.002 if held else 0.0)
    return load_arm().with_load(held + settings.carried_kg, np.zeros(3), turning)


def energies(settings: sim.ArmSettings, motion: sim.TrueMotion) -> Float:
    """Return the kinetic and potential energy of links, load, hand and motors, shape (n,). [J]"""
    model = model_of(settings).model
    data, links = mujoco.MjData(model), []
    for data.qpos[:], data.qvel[:] in zip(motion.q, motion.dq, strict=True):
        for step in ("kinematics", "comPos", "makeM", "energyPos", "energyVel"):
            getattr(mujoco, f"mj_{step}")(model, data)
        links.append(data.energy.sum())
    motors: Float = 0.5 * (ROTORS * motion.inner_dq**2).sum(axis=1)
    return np.array(links) + motors


def inverse_dynamics(settings: sim.ArmSettings, motion: sim.TrueMotion) -> Float:
    return model_of(settings).inverse_dynamics(motion.q, motion.dq, motion.inner_ddq)


work = partial(cumulative_trapezoid, dx=1e-3, axis=0, initial=0)  # of a power, from the start [J]


def at_rate(settings: sim.ArmSettings, rate_hz: float, monkeypatch: pytest.MonkeyPatch) -> sim.TrueMotion:
    monkeypatch.setattr(sim.settings, "CONTROL_RATE_HZ", rate_hz)
    return settings.move(make_streams(SEED, 7), "free swing", None).motion


@pytest.mark.parametrize("joints", [SMOOTH, PANDA_JOINTS], ids=["frictionless", "with friction"])
def test_free_swing_loses_what_friction_takes_and_errs_with_the_square_of_the_tick(
    joints: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    swing = replace(SWING, joints=joints)
    coarse, fine = (at_rate(swing, rate, monkeypatch) for rate in (1000.0, 2000.0))
    # It falls 60 J deep and swings at up to 15 rad/s.
    assert np.abs(fine.dq).max() > 5.0
    assert (fine.dissipated_j[-1].sum() > 1.0) == (joints == PANDA_JOINTS)
    totals = [energies(swing, motion) + motion.dissipated_j.sum(axis=1) for motion in (coarse, fine)]
    errors = [np.abs(total - total[0]) for total in totals]
    worst, finer = (error.max() for error in errors)
    assert worst < 2e-3
    assert 3.5 < worst / finer < 4.8
    as_fast_as_by_hand = np.maximum.accumulate(np.abs(coarse.dq).max(axis=1)) < 2.0
    assert errors[0][as_fast_as_by_hand].max() < 1e-5


# The hand's spring and damper at the flange, written once more, from poses and the intended path.


class Pull(NamedTuple):
    """What the hand does; n ticks."""

    torque_nm: Float  # torque at the joints, shape (n, 7) [N m]
    power_w: Float  # power into the arm and the hand's own mass, shape (n,) [W]


def intended(settings: sim.ArmSettings, seed: int, ticks: int) -> HandMotion:
    return plan_hand(settings.hand.path, ticks, 1e-3, make_streams(seed, 7).person)


def flange_poses(arm: Arm, q: Float) -> tuple[Float, Float, Float]:
    """Return positions of the flange, shape (n, 3), orientations, shape (n, 3, 3), and Jacobians, shape (n, 6, j)."""
    data = mujoco.MjData(arm.model)
    flange = arm.model.body(arm.flange).id
    position, turned, jacobian = np.empty((len(q), 3)), np.empty((len(q), 3, 3)), np.empty((len(q), 6, q.shape[1]))
    for k, data.qpos[:] in enumerate(q):
        mujoco.mj_kinematics(arm.model, data)
        mujoco.mj_comPos(arm.model, data)
        mujoco.mj_jacBody(arm.model, data, jacobian[k, :3], jacobian[k, 3:], flange)
        position[k], turned[k] = data.xpos[flange], data.xmat[flange].reshape(3, 3)
    return position, turned, jacobian


def pull(settings: sim.ArmSettings, seed: int, motion: sim.TrueMotion) -> Pull:
    arm, hand = load_arm(), settings.hand
    path = intended(settings, seed, len(motion.t) - 1)
    n = len(motion.q)
    flange, turned, jacobian = flange_poses(arm, motion.q)
    position, upright = flange[0], Rotation.from_matrix(turned[0])
    twist = np.einsum("kij,kj->ki", jacobian, motion.dq)
    off = position + path.position[:n] - flange
    # All rotations at a time: one by one they would take most of the time of the tests.
    turn = Rotation.from_rotvec(path.rotation[:n]) * upright * Rotation.from_matrix(turned).inv()
    force = hand.stiffness_n_per_m * off + hand.damping_ns_per_m * (path.velocity[:n] - twist[:, :3])
    force[:, 2] += hand.mass_kg * 9.81
    moment = hand.turning_stiffness_nm_per_rad * turn.as_rotvec()
    moment += hand.turning_damping_nms_per_rad * (path.angular[:n] - twist[:, 3:])
    wrench = np.hstack((force, moment))
    torque, power = np.einsum("kij,ki->kj", jacobian, wrench), np.sum(wrench * twist, axis=1)
    return Pull(torque, power)


@cache
def guided() -> tuple[sim.ArmSettings, sim.Simulation, sim.TrueMotion, Pull]:
    settings = sim.ArmSettings(sensors=IDEAL, duration_s=4.0, carried_kg=2.0)
    simulation = sim.simulate(settings, SEED)
    return settings, simulation, simulation.truth.motion, pull(settings, SEED, simulation.truth.motion)


def test_sensors_read_the_inverse_dynamics_of_the_links_less_the_hand() -> None:
    settings, simulation, motion, hand = guided()
    error = simulation.log.channels()["tau_J"] - inverse_dynamics(settings, motion) + hand.torque_nm
    # Where a joint breaks away or stops within half a tick, the prediction that the masses are taken at is off.
    assert np.abs(error).max() < 5e-4
    assert error.std(axis=0).max() < 1e-5


def test_energy_balances_in_every_joint_and_over_the_arm() -> None:
    settings, _, motion, hand = guided()
    taken, kinetic = motion.dissipated_j, 0.5 * ROTORS * motion.inner_dq**2
    assert_allclose(work(motion.interaction_nm * motion.inner_dq), taken + kinetic, atol=5e-5)
    gained = energies(settings, motion)
    motors = work(motion.support_nm * motion.inner_dq).sum(axis=1)
    assert_allclose(gained - gained[0], work(hand.power_w) + motors - taken.sum(axis=1), atol=2e-4)
    assert taken[-1].sum() > 0.5


def test_sensors_of_a_driven_arm_read_inverse_dynamics_and_friction() -> None:
    settings = sim.ArmSettings(sensors=IDEAL, duration_s=4.0, driven=True, carried_kg=1.0)
    simulation = sim.simulate(settings, SEED)
    motion = simulation.truth.motion
    error = simulation.log.channels()["tau_J"] - inverse_dynamics(settings, motion) - motion.friction_nm
    assert np.abs(error).max() < 3e-3
    assert error.std(axis=0).max() < 1e-4
