"""A hand that guides the arm: where it goes, which joints follow, where it rests, what it carries."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.joint_log import Float
from friction_audit.robot import load_arm
from friction_audit.simulation import (
    IDEAL_SENSORS,
    ArmSettings,
    Hidden,
    Simulation,
    TrueMotion,
    simulate,
)
from friction_audit.simulation.effects.load_and_place import GravityError
from tests.simulation.hand_at_flange import flange_poses, intended, pull

IDEAL = (IDEAL_SENSORS,) * 7
GUIDED = ArmSettings(sensors=IDEAL, duration_s=12.0)
SHORT = replace(GUIDED, duration_s=3.0)
LOWEST_RAD = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
HIGHEST_RAD = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])
FASTEST_RAD_S = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
SEED = 2


@pytest.fixture(scope="module")
def guided() -> Simulation:
    return simulate(GUIDED, SEED)


@pytest.fixture(scope="module")
def plain() -> Simulation:
    return simulate(SHORT, SEED)


def flange(motion: TrueMotion) -> Float:
    """Return the places of the flange, shape (n, 3). [m]"""
    return flange_poses(load_arm(), motion.q)[0]


def test_hand_follows_its_path(guided: Simulation) -> None:
    hand = pull(GUIDED, SEED, guided.truth.motion)
    assert hand.off_m.max() < 0.03
    assert np.sqrt((hand.off_m**2).mean()) < 0.01
    assert hand.turned_rad.max() < 0.2


@pytest.mark.parametrize(
    "seed", [*range(4), *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(4, 20))]
)
def test_motion_keeps_the_limits_of_a_panda(seed: int) -> None:
    motion = simulate(replace(GUIDED, duration_s=3.0), seed).truth.motion
    assert (motion.q > LOWEST_RAD + 0.1).all()
    assert (motion.q < HIGHEST_RAD - 0.1).all()
    assert (np.abs(motion.dq) < 0.95 * FASTEST_RAD_S).all()


def test_hand_comes_to_rest_in_every_pause(guided: Simulation) -> None:
    motion = guided.truth.motion
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
    assert simulation.log.tau_J is not None
    assert np.ptp(simulation.log.tau_J[:, 2]) > 0.5


def test_load_that_nobody_told_sags_and_gravity_compensation_stays_the_controllers(plain: Simulation) -> None:
    carrying = simulate(replace(SHORT, carried_kg=2.0), SEED)
    log, motion = carrying.log, carrying.truth.motion
    arm = load_arm()
    assert log.gravity is not None
    assert_allclose(log.gravity, arm.gravity(motion.q), atol=1e-4)
    sag = flange(motion)[499] - flange(plain.truth.motion)[499]
    weight_on_the_spring = 2.0 * 9.81 / GUIDED.hand.stiffness_n_per_m
    assert -weight_on_the_spring * 1.02 < sag[2] < -0.7 * weight_on_the_spring


def test_gravity_error_changes_what_is_logged_and_nothing_else(plain: Simulation) -> None:
    hidden = (Hidden(gravity_error=GravityError(torque_nm=0.3)),) * 7
    wrong = simulate(replace(SHORT, hidden=hidden), SEED)
    assert_array_equal(wrong.truth.motion.q, plain.truth.motion.q)
    log, plain_log = wrong.log.channels(), plain.log.channels()
    for name in ("q", "dq", "tau_J"):
        assert_array_equal(log[name], plain_log[name])
    assert_allclose(log["gravity"] - plain_log["gravity"], 0.3 * np.sin(log["q"]), atol=2e-6)
    assert np.abs(log["tau_ext_hat_filtered"] - plain_log["tau_ext_hat_filtered"]).max() > 0.1
