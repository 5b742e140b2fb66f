"""A compensator that the log does not contain: found beside Coulomb friction that is held, untestable elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.diagnose_joint import Subject, diagnose_joint
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects import stribeck, unlogged_compensation
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import JointModel, simple_model
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint

STATED = simple_model(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)
HELD = replace(STATED, held=("coulomb",))
SHARE, WIDTH_RAD_S = 0.6, 0.2


def helped(data: JointData) -> Float:
    """What a compensator of a share of both frictions takes off, smooth below a speed."""
    believed = COULOMB_NM * np.tanh(data.dq / WIDTH_RAD_S) + VISCOUS_NMS_PER_RAD * data.dq
    return np.asarray(-SHARE * believed)


def rising(data: JointData) -> Float:
    """Friction above Coulomb's towards rest."""
    return np.asarray(0.15 * np.sign(data.dq) * np.exp(-((data.dq / WIDTH_RAD_S) ** 2)))


def diagnosed(data: JointData, model: JointModel | None) -> JointDiagnosis:
    one = Subject(data=data, number=1, name="elbow", findings=(), from_energy={}, model=model)
    return diagnose_joint(one, (stribeck.EFFECT, unlogged_compensation.EFFECT), DiagnosisSettings())


def test_a_compensator_beside_stated_coulomb_friction_is_named_with_its_size() -> None:
    found = diagnosed(moved_joint(helped, noise_nm=0.02), HELD)
    assert (found.verdict, [effect.name for effect in found.effects]) == ("named", ["unlogged_compensation"])
    numbers = found.effects[0].parameters
    assert numbers["unlogged_nm"].value == pytest.approx(SHARE * COULOMB_NM, rel=0.05)
    assert numbers["unlogged_width_rad_s"].value == pytest.approx(WIDTH_RAD_S, rel=0.1)
    assert found.augmented["viscous_nms_per_rad"].value == pytest.approx((1.0 - SHARE) * VISCOUS_NMS_PER_RAD, abs=0.005)


@pytest.mark.parametrize("model", [None, pytest.param(STATED, marks=pytest.mark.thorough)])
def test_where_friction_is_fitted_it_cannot_be_said(model: JointModel | None) -> None:
    found = diagnosed(moved_joint(helped, noise_nm=0.02), model)
    assert all(effect.name != "unlogged_compensation" for effect in found.effects)
    assert "log the commanded torque" in found.untestable["unlogged_compensation"]


def test_without_one_nothing_is_said() -> None:
    assert diagnosed(moved_joint(noise_nm=0.02), HELD).verdict == "adequate"


def test_friction_above_what_is_stated_is_none() -> None:
    found = diagnosed(moved_joint(rising, noise_nm=0.02), HELD)
    assert [effect.name for effect in found.effects] == ["stribeck"]
