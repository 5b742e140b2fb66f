"""From where to where a play and what is behind it are looked for."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.sought import FAR_OFF, OFF, seek
from friction_audit.dynamics.transmission import FarSide
from friction_audit.effects.backlash import CONTACT_DAMPING_RATIO, SOUGHT_CONTACTS_HZ, SOUGHT_TIMES
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.effects.joint_elasticity import EFFECT as ELASTICITY
from friction_audit.effects.joint_model import simple_model
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint

SHAPE = {"gap_rad": 1e-3, "contact_hz": 30.0}


@pytest.fixture(scope="module")
def ground() -> Ground:
    return make_ground(moved_joint(duration_s=20.0), None, 0)


def test_it_begins_with_the_shape_and_the_declared_model(ground: Ground) -> None:
    sought = seek(BACKLASH, SHAPE, ground, ground.baseline())
    assert sought.shape_at(sought.start) == pytest.approx({**SHAPE, "flank_damping_ratio": CONTACT_DAMPING_RATIO})
    assert sought.of_model == ground.declared.names
    assert sought.model_at(sought.start) == pytest.approx([COULOMB_NM, VISCOUS_NMS_PER_RAD, INERTIA_KG_M2], rel=1e-3)
    expected = FarSide(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)
    far = sought.far_side_at(sought.start)
    assert (far.inertia_kg_m2, far.coulomb_nm) == pytest.approx((expected.inertia_kg_m2, expected.coulomb_nm), rel=1e-3)


def test_widths_and_friction_lie_on_both_sides_and_viscous_friction_may_be_none(ground: Ground) -> None:
    sought = seek(BACKLASH, SHAPE, ground, ground.baseline())
    low, high = sought.shape_at(sought.low), sought.shape_at(sought.high)
    assert (low["gap_rad"], high["gap_rad"]) == pytest.approx((1e-3 / SOUGHT_TIMES, 1e-3 * SOUGHT_TIMES))
    assert (low["contact_hz"], high["contact_hz"]) == pytest.approx(SOUGHT_CONTACTS_HZ)
    coulomb, viscous = sought.of_model.index("coulomb_nm"), sought.of_model.index("viscous_nms_per_rad")
    assert sought.model_at(sought.low)[coulomb] == pytest.approx(COULOMB_NM / OFF, rel=1e-3)
    assert sought.model_at(sought.high)[coulomb] == pytest.approx(COULOMB_NM * OFF, rel=1e-3)
    assert sought.model_at(sought.low)[viscous] == 0.0
    assert sought.model_at(sought.high)[viscous] > VISCOUS_NMS_PER_RAD


def test_a_shape_of_which_less_is_behind_keeps_that(ground: Ground) -> None:
    sought = seek(BACKLASH, {**SHAPE, "far_share": 0.8}, ground, ground.baseline())
    assert sought.shape_at(sought.high)["far_share"] == 0.8


def test_a_spring_is_looked_for_as_stiff_as_it_was_found_soft_at_first_or_not(ground: Ground) -> None:
    straight = seek(ELASTICITY, {"spring_nm_per_rad": 500.0}, ground, ground.baseline())
    assert straight.of_shape == ("spring_nm_per_rad", "damping_ratio")
    assert straight.shape_at(0.5 * (straight.low + straight.high))["spring_nm_per_rad"] == pytest.approx(500.0)
    soft = seek(ELASTICITY, {"spring_nm_per_rad": 500.0, "soft_nm": 1e-9}, ground, ground.baseline())
    assert soft.of_shape == ("spring_nm_per_rad", "damping_ratio", "soft_nm")
    assert soft.shape_at(soft.low)["soft_nm"] == pytest.approx(soft.shape_at(soft.start)["soft_nm"])


def test_a_hidden_play_may_be_any_wide_one_and_hide_most_of_the_inertia(ground: Ground) -> None:
    sought = seek(BACKLASH, SHAPE, ground, ground.baseline(), everywhere=True)
    span = np.ptp(ground.data.q)
    low, high = sought.shape_at(sought.low), sought.shape_at(sought.high)
    assert (low["gap_rad"], high["gap_rad"]) == pytest.approx((1e-3 * span, 0.08 * span))
    inertia = sought.of_model.index("inertia_kg_m2")
    assert sought.model_at(sought.high)[inertia] == pytest.approx(FAR_OFF * INERTIA_KG_M2, rel=1e-2)


def test_an_inertia_that_was_stated_is_not_looked_for() -> None:
    stated = simple_model(inertia_kg_m2=0.25, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
    ground = make_ground(moved_joint(duration_s=20.0), stated, 0)
    sought = seek(BACKLASH, SHAPE, ground, ground.baseline())
    assert "inertia_kg_m2" not in sought.of_model
    assert sought.far_side_at(sought.high).inertia_kg_m2 == 0.25
    assert np.all(sought.low <= sought.start)
    assert np.all(sought.start <= sought.high)


def test_numbers_below_zero_count_as_none(ground: Ground) -> None:
    wrong = replace(ground.baseline(), inertia_kg_m2=-0.1, coulomb_nm=-0.2, viscous_nms_per_rad=-0.3)
    sought = seek(BACKLASH, SHAPE, ground, wrong)
    assert np.all(sought.low <= sought.start)
    assert np.all(sought.start <= sought.high)
    assert sought.far_side_at(sought.low) == FarSide(inertia_kg_m2=0.0, coulomb_nm=0.0, viscous_nms_per_rad=0.0)
