"""The interval of a time constant holds the time by which the friction fades, under either law."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.discrepancy.alternatives import Naming
from friction_audit.discrepancy.candidates.warm_up import CANDIDATE, by_viscosity
from friction_audit.discrepancy.ground import Ground, make_ground
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.naming import Found
from friction_audit.discrepancy.profile_time import time_interval
from friction_audit.discrepancy.refine import refine
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.discrepancy.moved_joint import COULOMB_NM, VISCOUS_NMS_PER_RAD, moved_joint

TIME_S = 15.0
STEEP = 1.2
"""Logarithm of the friction of the cold joint over that of the warm one."""


def straight(data: JointData) -> Float:
    warm = COULOMB_NM * np.sign(data.dq) + VISCOUS_NMS_PER_RAD * data.dq
    return np.asarray(np.expm1(STEEP) * np.exp(-data.t / TIME_S) * warm)


def viscous(data: JointData) -> Float:
    warm = COULOMB_NM * np.sign(data.dq) + VISCOUS_NMS_PER_RAD * data.dq
    return np.asarray(np.expm1(STEEP * np.exp(-data.t / TIME_S)) * warm)


def told(ground: Ground) -> tuple[Found, Coefficient]:
    start = {"warm_up_time_s": TIME_S, "warm_up_per_k": 1e-6}
    shape = refine(CANDIDATE, start, CANDIDATE.tried(ground.data), ground, ground.baseline(), ground.base)
    columns = ground.rows.of(CANDIDATE.columns(ground.data, ground.baseline(), shape))
    found = Found(
        candidate=CANDIDATE,
        shape=shape,
        columns=columns,
        naming=Naming(name=CANDIDATE.name, rivals=(), alternatives=()),
        p_value=0.01,
    )
    return found, time_interval(found, ground, ground.baseline(columns), ground.base)


@pytest.mark.parametrize("law", [straight, viscous])
def test_the_time_is_held_whichever_law_it_follows(law: Callable[[JointData], Float]) -> None:
    found, number = told(make_ground(moved_joint(law, noise_nm=0.03, duration_s=40.0), None, 0))
    assert number.value == found.shape["warm_up_time_s"]
    assert 0.0 < number.low <= TIME_S <= number.high < 4.0 * TIME_S


def test_one_law_alone_misses_the_time_of_the_other() -> None:
    ground = make_ground(moved_joint(viscous, noise_nm=0.005, duration_s=40.0), None, 0)
    found, _ = told(ground)
    alone = replace(found, candidate=replace(CANDIDATE, other_laws=()))
    number = time_interval(alone, ground, ground.baseline(found.columns), ground.base)
    assert number.high < TIME_S


def test_a_time_that_the_log_does_not_tell_has_no_bounds() -> None:
    def nothing(data: JointData) -> Float:
        return 1e-3 * straight(data)

    _, number = told(make_ground(moved_joint(nothing, noise_nm=0.05, duration_s=40.0), None, 0))
    assert (number.low, number.high) == (-np.inf, np.inf)


def test_both_laws_are_one_where_little_fades() -> None:
    data = moved_joint(straight, noise_nm=0.0, duration_s=10.0)
    shape = {"warm_up_time_s": TIME_S, "warm_up_per_k": 1e-6}
    baseline = make_ground(data, None, 0).baseline()
    usual = CANDIDATE.columns(data, baseline, shape)
    assert by_viscosity(data, baseline, shape, 1e-6) == pytest.approx(usual, abs=1e-5)
    steep = by_viscosity(data, baseline, shape, 2.0)
    assert steep[0] == pytest.approx(usual[0])
    assert np.abs(steep[-1]).max() < np.abs(usual[-1]).max()
