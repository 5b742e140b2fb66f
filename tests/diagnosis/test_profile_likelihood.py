"""The width of a play by profile likelihood: the best of many valleys, and an interval that holds the truth."""

import numpy as np
import pytest

from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.profile_likelihood import profile_number
from friction_audit.diagnosis.valleys import FARTHEST
from friction_audit.dynamics.transmission import FarSide, Transmission
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint
from tests.dynamics.joints import added_torque

FAR = FarSide(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)
GAP_RAD = 8e-4


def play(data: JointData) -> Float:
    flanks = Transmission(stiffness_nm_per_rad=12e3, damping_ratio=0.15, gap_rad=GAP_RAD)
    return added_torque(data.motion(), FAR, flanks)


@pytest.mark.parametrize("begin", [0.7, 1.4])
def test_the_width_is_found_from_far_off_and_its_interval_holds_it(begin: float) -> None:
    ground = make_ground(moved_joint(play, noise_nm=0.02, duration_s=60.0), None, 0)
    shape = {"gap_rad": begin * GAP_RAD, "contact_hz": 22.0}
    baseline = ground.baseline(ground.rows.of(play(ground.data)[:, None]))
    found = profile_number(BACKLASH, shape, ground, baseline, ground.base)
    assert found.number.value == pytest.approx(GAP_RAD, rel=0.06)
    assert found.number.low < GAP_RAD < found.number.high
    assert found.shape["gap_rad"] == found.number.value
    assert found.number.high - found.number.low < GAP_RAD


def test_no_value_is_tried_beyond_the_farthest() -> None:
    ground = make_ground(moved_joint(play, duration_s=20.0), None, 0)
    shape = {"gap_rad": 3.0 * GAP_RAD, "contact_hz": 22.0}
    baseline = ground.baseline()
    found = profile_number(BACKLASH, shape, ground, baseline, ground.base)
    assert found.number.value >= shape["gap_rad"] / FARTHEST * (1.0 - 1e-9)


def test_flanks_give_way_by_friction_over_stiffness() -> None:
    ground = make_ground(moved_joint(duration_s=20.0), None, 0)
    soft = 0.5 * BACKLASH.systematic_error(ground.baseline(), {"gap_rad": 1e-3, "contact_hz": 20.0})
    assert soft == pytest.approx(COULOMB_NM / (INERTIA_KG_M2 * (2.0 * np.pi * 20.0) ** 2), rel=0.01)
