"""Inertia that a model has taken out of the torque: the diagonal of the mass matrix, by Pinocchio's own."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.known_inertia import known_inertias
from friction_audit.robot import load_arm
from tests.synthetic_interaction import choice

ARM = load_arm()
POSE = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
DRIVEN = replace(choice(gravity="model"), source="tau_J", drive="robot", inertia="model")


def test_at_one_pose_it_is_the_diagonal_of_the_mass_matrix() -> None:
    pin = pytest.importorskip("pinocchio")
    mass = np.asarray(pin.crba(ARM.model, ARM.model.createData(), POSE))
    assert known_inertias(ARM, DRIVEN, np.tile(POSE, (10, 1))) == pytest.approx(np.diag(mass), rel=1e-9)


def test_along_a_motion_it_is_the_mean() -> None:
    poses = POSE + np.array([[0.0], [0.4]])
    one, other = (known_inertias(ARM, DRIVEN, pose[None]) for pose in poses)
    assert known_inertias(ARM, DRIVEN, poses) == pytest.approx(0.5 * (one + other))


def test_where_no_model_took_it_there_is_none() -> None:
    q = np.tile(POSE, (10, 1))
    assert np.array_equal(known_inertias(ARM, replace(DRIVEN, inertia="none"), q), np.zeros(7))
    assert np.array_equal(known_inertias(None, DRIVEN, q), np.zeros(7))
