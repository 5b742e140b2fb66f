"""Entries of the regressor against the arm's own dynamics."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.joint_log import Float
from friction_audit.robot import load_arm
from friction_audit.robot.regressor import news, random_motion, regressor_entries, tilt_torque

ARM = load_arm()
MOTION = random_motion(7, moving=True)


def test_regressor_times_parameters_is_the_torque() -> None:
    joints, links, places = np.full(70, 3), np.repeat(np.arange(7), 10), np.tile(np.arange(10), 7)
    parameters = np.concatenate([body.toDynamicParameters() for body in ARM.model.inertias[1:]])
    torque = regressor_entries(ARM, MOTION, joints, links, places) @ parameters
    assert torque == pytest.approx(ARM.inverse_dynamics(*MOTION)[:, 3])


def test_columns_of_a_log_in_another_order() -> None:
    turned = replace(ARM, columns=tuple(range(6, -1, -1)))
    backwards: tuple[Float, Float, Float] = (MOTION[0][:, ::-1], MOTION[1][:, ::-1], MOTION[2][:, ::-1])
    entries = (np.array([5, 2]), np.array([6, 4]), np.array([0, 2]))
    mirrored = (np.array([1, 4]), np.array([0, 2]), np.array([0, 2]))
    assert regressor_entries(turned, backwards, *mirrored) == pytest.approx(regressor_entries(ARM, MOTION, *entries))
    assert tilt_torque(turned, backwards[0]) == pytest.approx(tilt_torque(ARM, MOTION[0])[:, ::-1])


def test_a_tilted_base_to_first_order() -> None:
    tilted = load_arm(gravity_vector=(0.01, 0.02, -9.81))
    _, across = np.linalg.svd(ARM.model.gravity.linear[None])[1:]
    factors = across[1:] @ np.array([0.01, 0.02, 0.0])
    found = tilt_torque(ARM, MOTION[0]) @ factors
    assert found == pytest.approx(tilted.gravity(MOTION[0]) - ARM.gravity(MOTION[0]), abs=1e-9)


def test_news_leaves_out_combinations_of_what_stands_before() -> None:
    first, second = np.arange(5.0), np.ones(5)
    columns = np.column_stack([first, second, first - 2 * second, np.zeros(5), first**2])
    assert news(columns).tolist() == [True, True, False, False, True]
    assert not news(np.zeros((5, 2))).any()
