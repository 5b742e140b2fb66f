"""The interval of a spring on a noisy position reaches the spring that is there."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.alternatives import Naming
from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.naming import Found
from friction_audit.diagnosis.noise_reach import Reach, reach_of_noise
from friction_audit.dynamics.transmission import FarSide, Transmission
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_elasticity import EFFECT as CANDIDATE
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint
from tests.dynamics.joints import added_torque

FAR = FarSide(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)
STIFFNESS = INERTIA_KG_M2 * (2.0 * np.pi * 12.0) ** 2


def spring(data: JointData) -> Float:
    return added_torque(data.motion(), FAR, Transmission(stiffness_nm_per_rad=STIFFNESS, damping_ratio=0.03))


def reach(data: JointData) -> Reach:
    ground = make_ground(data, None, 0)
    shape = {"spring_nm_per_rad": STIFFNESS}
    found = Found(
        candidate=CANDIDATE,
        shape=shape,
        columns=ground.rows.of(CANDIDATE.regressor(data, ground.baseline(), shape)),
        naming=Naming(name=CANDIDATE.name, rivals=(), alternatives=()),
        p_value=0.01,
    )
    return reach_of_noise(found, ground, ground.baseline(found.columns), ground.base)


def test_without_noise_it_does_not_reach_far() -> None:
    found = reach(moved_joint(spring, noise_nm=0.005, duration_s=20.0))
    assert (found.low, found.high) == pytest.approx((1.0, 1.0), abs=0.02)


def test_with_noise_it_reaches_farther() -> None:
    still = moved_joint(spring, noise_nm=0.005, duration_s=20.0)
    shaken = replace(still, q=still.q + np.random.default_rng(5).normal(0.0, 4e-6, len(still.q)))
    calm, noisy = reach(still), reach(shaken)
    assert noisy.high - noisy.low > 2.0 * (calm.high - calm.low)
    assert noisy.low <= 1.0 <= noisy.high


def test_by_hand() -> None:
    number = Coefficient(value=2.0, low=1.9, high=2.1)
    one = Reach(low=0.9, high=1.25)
    assert one.widen(number) == Coefficient(value=2.0, low=1.8, high=2.5)
    assert one.widen(number, -1) == Coefficient(value=2.0, low=1.6, high=2.0 / 0.9)
