"""The interval of a time constant holds the time by which the friction fades."""

import numpy as np
import pytest

from friction_audit.diagnosis.alternatives import Naming
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.naming import Found
from friction_audit.diagnosis.profile_time import time_interval
from friction_audit.diagnosis.refine import refine
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.warm_up import EFFECT as CANDIDATE
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import COULOMB_NM, VISCOUS_NMS_PER_RAD, moved_joint

TIME_S = 15.0
STEEP = 1.2
"""Logarithm of the friction of the cold joint over that of the warm one."""


def fades(data: JointData) -> Float:
    warm = COULOMB_NM * np.sign(data.dq) + VISCOUS_NMS_PER_RAD * data.dq
    return np.asarray(np.expm1(STEEP) * np.exp(-data.t / TIME_S) * warm)


def falls_faster_at_first(data: JointData) -> Float:
    """Friction over that of the warm joint is an exponential of the temperature."""
    warm = COULOMB_NM * np.sign(data.dq) + VISCOUS_NMS_PER_RAD * data.dq
    return np.asarray(np.expm1(STEEP / 2.0 * np.exp(-data.t / TIME_S)) * warm)


def told(ground: Ground) -> tuple[Found, Coefficient]:
    start = {"warm_up_time_s": TIME_S, "warm_up_per_k": 1e-6}
    shape = refine(CANDIDATE, start, CANDIDATE.grid(ground.data), ground, ground.baseline(), ground.base)
    columns = ground.rows.of(CANDIDATE.regressor(ground.data, ground.baseline(), shape))
    found = Found(
        candidate=CANDIDATE,
        shape=shape,
        columns=columns,
        naming=Naming(name=CANDIDATE.name, rivals=(), alternatives=()),
        p_value=0.01,
    )
    return found, time_interval(found, ground, ground.baseline(columns), ground.base)


@pytest.mark.parametrize("noise_nm", [0.005, 0.03])
def test_the_time_is_held(noise_nm: float) -> None:
    found, number = told(make_ground(moved_joint(fades, noise_nm=noise_nm, duration_s=40.0), None, 0))
    assert number.value == found.shape["warm_up_time_s"]
    assert 0.0 < number.low <= TIME_S <= number.high < 2.0 * TIME_S


def test_the_time_is_held_where_friction_falls_faster_at_first() -> None:
    found, number = told(make_ground(moved_joint(falls_faster_at_first, noise_nm=0.03, duration_s=40.0), None, 0))
    assert found.shape["warm_up_time_s"] < 0.9 * TIME_S
    assert number.low <= TIME_S <= number.high < 2.0 * TIME_S


def test_a_time_that_the_log_does_not_tell_has_no_bounds() -> None:
    def nothing(data: JointData) -> Float:
        return 1e-3 * fades(data)

    _, number = told(make_ground(moved_joint(nothing, noise_nm=0.05, duration_s=40.0), None, 0))
    assert (number.low, number.high) == (-np.inf, np.inf)
