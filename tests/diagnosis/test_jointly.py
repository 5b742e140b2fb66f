"""A play or a spring whose numbers, friction and inertia are all a little wrong is found at once, not by turns."""

import numpy as np
import pytest

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.jointly import fit_jointly
from friction_audit.dynamics.transmission import FarSide, Transmission
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_elasticity import EFFECT as ELASTICITY
from friction_audit.effects.stribeck import EFFECT as STRIBECK
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint
from tests.dynamics.joints import added_torque

FAR = FarSide(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)
GAP_RAD, OFFSET_NM = 8e-3, 0.1
STIFFNESS_NM_PER_RAD, SOFT_NM = 800.0, 1.0
FLANKS = Transmission(stiffness_nm_per_rad=12e3, damping_ratio=0.15, gap_rad=GAP_RAD)


def play_and_offset(data: JointData) -> Float:
    return added_torque(data.motion(), FAR, FLANKS) + OFFSET_NM


def soft_gear(data: JointData) -> Float:
    spring = Transmission(stiffness_nm_per_rad=STIFFNESS_NM_PER_RAD, damping_ratio=0.04, soft_nm=SOFT_NM)
    return added_torque(data.motion(), FAR, spring)


@pytest.fixture(scope="module")
def ground() -> Ground:
    return make_ground(moved_joint(play_and_offset, noise_nm=0.02, duration_s=30.0), None, 0)


def offset(ground: Ground) -> Float:
    return ground.rows.of(np.ones((len(ground.data.t), 1)))


def left_by(ground: Ground, columns: Float) -> float:
    w = ground.working
    return Beside(np.hstack([ground.base, offset(ground)])[w], ground.y[w]).fit(columns[w])[1]


@pytest.mark.parametrize("begin", [0.7, 1.4])
def test_width_friction_and_inertia_are_found_beside_an_offset(ground: Ground, begin: float) -> None:
    shape = {"gap_rad": begin * GAP_RAD, "contact_hz": 22.0}
    own = ground.rows.of(BACKLASH.regressor(ground.data, ground.baseline(offset(ground)), shape))
    found = fit_jointly(BACKLASH, shape, own, ground, offset(ground))
    assert found is not None
    # Softer flanks strike as a wider play would, so that the valley is a long one.
    assert found.shape["gap_rad"] == pytest.approx(GAP_RAD, rel=0.1)
    assert found.baseline.inertia_kg_m2 == pytest.approx(INERTIA_KG_M2, rel=0.02)
    assert found.baseline.coulomb_nm == pytest.approx(COULOMB_NM, rel=0.02)
    assert found.baseline.viscous_nms_per_rad == pytest.approx(VISCOUS_NMS_PER_RAD, rel=0.1)
    assert left_by(ground, found.columns) < 0.1 * left_by(ground, own)


@pytest.fixture(scope="module")
def soft_ground() -> Ground:
    return make_ground(moved_joint(soft_gear, noise_nm=0.02, duration_s=30.0), None, 0)


@pytest.mark.parametrize("begin", [0.8, 1.25])
def test_stiffness_stiffening_friction_and_inertia_are_found(soft_ground: Ground, begin: float) -> None:
    shape = {"spring_nm_per_rad": begin * STIFFNESS_NM_PER_RAD, "soft_nm": 0.4}
    nothing = np.zeros((len(soft_ground.y), 0))
    own = soft_ground.rows.of(ELASTICITY.regressor(soft_ground.data, soft_ground.baseline(), shape))
    found = fit_jointly(ELASTICITY, shape, own, soft_ground, nothing)
    assert found is not None
    assert found.shape["spring_nm_per_rad"] == pytest.approx(STIFFNESS_NM_PER_RAD, rel=0.05)
    assert found.shape["soft_nm"] == pytest.approx(SOFT_NM, rel=0.2)
    assert found.baseline.inertia_kg_m2 == pytest.approx(INERTIA_KG_M2, rel=0.02)
    w = soft_ground.working
    (compliance,), _ = Beside(soft_ground.base[w], soft_ground.y[w]).fit(found.columns[w])
    assert compliance == pytest.approx(1.0 / STIFFNESS_NM_PER_RAD, rel=0.05)


def test_columns_are_those_of_the_shape_and_the_declared_model_that_are_told(ground: Ground) -> None:
    shape = {"gap_rad": GAP_RAD, "contact_hz": 50.0}
    own = ground.rows.of(BACKLASH.regressor(ground.data, ground.baseline(offset(ground)), shape))
    found = fit_jointly(BACKLASH, shape, own, ground, offset(ground))
    assert found is not None
    again = ground.rows.of(BACKLASH.regressor(ground.data, found.baseline, found.shape))
    np.testing.assert_allclose(again, found.columns, atol=1e-6)


def test_where_nothing_leaves_less_there_is_no_answer(ground: Ground) -> None:
    perfect = ground.residual(offset(ground))[:, None]
    shape = {"gap_rad": 40.0 * GAP_RAD, "contact_hz": 22.0}
    assert fit_jointly(BACKLASH, shape, perfect, ground, offset(ground)) is None


def test_an_effect_with_nothing_behind_it_is_none_of_its() -> None:
    ground = make_ground(moved_joint(duration_s=20.0), None, 0)
    (shape, *_) = STRIBECK.grid(ground.data)
    assert fit_jointly(STRIBECK, shape, np.zeros((len(ground.y), 1)), ground, np.zeros((len(ground.y), 0))) is None
