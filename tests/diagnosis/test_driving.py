from collections.abc import Callable

import numpy as np
import pytest

from friction_audit.diagnosis.driving import driving
from friction_audit.diagnosis.ground import make_ground
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint

Torque = Callable[[JointData], Float]


def falling(speed: float, exponent: float) -> Torque:
    return lambda data: np.sign(data.dq) * np.exp(-((np.abs(data.dq) / speed) ** exponent))


def rising(speed: float) -> Torque:
    return lambda data: np.tanh(data.dq / speed)


def driver(missing: Torque, *effects: Torque) -> int | None:
    ground = make_ground(moved_joint(missing, noise_nm=0.01), None, 0)
    return driving(ground, [ground.rows.of(effect(ground.data)[:, None]) for effect in effects])


def steep(data: JointData) -> Float:
    """Friction that falls more steeply than the Stribeck curve beside which it is fitted."""
    return 0.6 * falling(0.4, 3.5)(data)


@pytest.mark.parametrize("place", [0, 1])
def test_of_two_curves_that_nearly_cancel_the_one_that_explains_less_is_none(place: int) -> None:
    """A curve that rises makes up for the form of one that falls; alone it would have to fall itself."""
    effects = [falling(0.2, 1.5)]
    effects.insert(place, rising(0.2))
    assert driver(steep, *effects) == place


def test_a_curve_beside_which_friction_still_rubs_drives_nothing() -> None:
    assert driver(steep, falling(0.4, 3.5)) is None
    assert driver(steep, falling(0.1, 1.5), rising(0.3)) is None


def test_a_curve_that_leaves_less_than_nothing_to_friction_is_none() -> None:
    """Three times a curve that starts at 1 N m takes 3 N m, of which the joint rubs with a half only."""

    def curve(data: JointData) -> Float:
        return np.asarray(np.sign(data.dq) * (1.0 + 0.1 * data.dq**2))

    assert driver(lambda data: 3.0 * curve(data) - 2.8 * np.sign(data.dq), curve) == 0
