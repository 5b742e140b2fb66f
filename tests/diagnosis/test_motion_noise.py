"""Noise of the motion in columns: as much again, seen in what they change."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.motion_noise import noise_in_columns, noisier
from friction_audit.effects.joint_data import JointData, grid_noise
from friction_audit.effects.registry import effects
from tests.diagnosis.moved_joint import moved_joint


@pytest.fixture(scope="module")
def still() -> JointData:
    """A joint that moves without noise."""
    return moved_joint(lambda data: 0.0 * data.q)


def shaken(data: JointData, size: float) -> JointData:
    """The same with noise of the position, seen through the grid's own filter, and its derivatives."""
    silent = replace(data, derived_from="q")
    noise = noisier(silent, np.random.default_rng(5)).q - data.q
    noise *= size / noise.std()
    slope = np.gradient(noise, data.step_s)
    ddq = data.ddq + np.gradient(slope, data.step_s)
    return replace(silent, q=data.q + noise, dq=data.dq + slope, ddq=ddq)


def test_as_much_noise_again_is_added_to_position_velocity_and_acceleration(still: JointData) -> None:
    once = shaken(still, 1e-4)
    twice = noisier(once, np.random.default_rng(1))
    for name in ("q", "dq", "ddq"):
        first, second = (getattr(two, name) - getattr(one, name) for one, two in ((still, once), (once, twice)))
        assert second.std() == pytest.approx(first.std(), rel=0.15)
        assert abs(np.corrcoef(first, second)[0, 1]) < 0.1
    assert grid_noise(twice.q, differences=4) == pytest.approx(
        np.sqrt(2.0) * grid_noise(once.q, differences=4), rel=0.1
    )


def test_a_velocity_of_its_own_gets_its_own_noise(still: JointData) -> None:
    rng = np.random.default_rng(2)
    logged = still.dq + noisier(shaken(still, 1e-2), rng).q - shaken(still, 1e-2).q
    data = replace(still, dq=logged, logged_dq=logged, derived_from="dq")
    added = noisier(data, rng).dq - data.dq
    assert added.std() == pytest.approx((logged - still.dq).std(), rel=0.15)


def changes(ground: Ground, name: str, **shape: float) -> np.ndarray:
    candidate = next(one for one in effects() if one.name == name)
    return noise_in_columns(ground, candidate, ground.baseline(), shape, np.random.default_rng(3))


def test_columns_of_place_change_by_the_noise_and_those_of_time_not_at_all(still: JointData) -> None:
    ground = make_ground(shaken(still, 1e-3), None, 0)
    spring = changes(ground, "cable_spring")[:, 0]
    through = ground.rows.kernel @ ground.rows.kernel
    assert 0.0 < spring.std() < 1e-3
    assert spring.std() > 0.5e-3 * np.sqrt(through)
    assert not changes(ground, "torque_bias").any()
