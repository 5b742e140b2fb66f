"""The augmented model holds the nominal terms as fitted together with the effects, and the effects."""

from dataclasses import replace
from typing import Any

import pytest

from friction_audit.diagnosis.augmented_model import augment_models
from friction_audit.diagnosis.result import Discrepancy, JointDiagnosis
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import BIAS, DATA_FAULT, NAMED, NONE, STRIBECK, coefficient

LOG = build_estimate(3, count=4, rate=100.0).log
STRIBECK_TERM = FittedTerm("stribeck", (0.2, 0.05, 1.0))


def augmented(*joints: JointDiagnosis, nominal: ArmModel | None = None) -> Any:
    result = augment_models(Discrepancy(joints=joints), LOG, nominal)
    assert result.lacking == ()
    return result.model


def nominal_arm(*terms: FittedTerm) -> ArmModel:
    joint = JointModel(inertia_kg_m2=0.5, terms=(FittedTerm("coulomb", (0.4,)), FittedTerm("viscous", (0.1,)), *terms))
    return ArmModel(names=LOG.joint_names, joints=(joint,) * 3)


def test_a_missing_effect_is_a_term_the_rest_is_as_fitted_with_it_and_its_origin_is_stated() -> None:
    joint = augmented(NAMED).joints[0]
    assert (joint.inertia_kg_m2, joint.values("coulomb"), joint.values("viscous")) == (0.3, (0.30,), (0.07,))
    assert joint.values("stribeck") == (0.15, 0.1, 2.0)
    assert joint.provenance == Provenance(method="diagnose", log="run 1.csv", sha256="0" * 64, cycles=30)


def test_there_is_one_entry_per_joint_of_the_log() -> None:
    model = augmented(NONE)
    assert model.names == LOG.joint_names
    assert [joint is not None for joint in model.joints] == [False, False, True]


def test_a_joint_that_was_not_fitted_keeps_its_nominal_model() -> None:
    arm = nominal_arm()
    assert augmented(replace(DATA_FAULT, joint=2), nominal=arm).joints == arm.joints


def test_a_stated_inertia_stays_and_nominal_terms_keep_their_shape() -> None:
    fitted = {"coulomb_nm": coefficient(0.35, 0.1), "viscous_nms_per_rad": coefficient(0.09, 0.1)}
    fitted |= {"stribeck_excess_nm": coefficient(0.25, 0.1)}
    joint = augmented(replace(NONE, joint=1, augmented=fitted), nominal=nominal_arm(STRIBECK_TERM)).joints[0]
    assert joint.inertia_kg_m2 == 0.5
    assert joint.values("coulomb") == (0.35,)
    assert joint.values("stribeck") == (0.25, 0.05, 1.0)


def test_what_is_held_stays_as_it_was_and_held() -> None:
    fitted = {"viscous_nms_per_rad": coefficient(0.09, 0.1)}
    arm = nominal_arm()
    held = replace(arm, joints=tuple(joint and replace(joint, held=("coulomb",)) for joint in arm.joints))
    joint = augmented(replace(NONE, joint=1, augmented=fitted), nominal=held).joints[0]
    assert (joint.values("coulomb"), joint.values("viscous"), joint.held) == ((0.4,), (0.09,), ("coulomb",))


def test_friction_below_zero_is_no_model_and_said_unless_it_may_be_zero() -> None:
    wrong = replace(NAMED, augmented=NAMED.augmented | {"viscous_nms_per_rad": coefficient(-0.01, 0.005)})
    result = augment_models(Discrepancy(joints=(wrong,)), LOG, None)
    assert result.model.joints == (None, None, None)
    ((joint, lack),) = result.lacking
    assert joint == 1
    assert "viscous_nms_per_rad = -0.01; expected a number from 0" in lack
    maybe = {**NAMED.augmented, "viscous_nms_per_rad": coefficient(-0.01, 0.02)}
    assert augmented(replace(NAMED, augmented=maybe)).joints[0].values("viscous") == (0.0,)


def test_a_term_of_the_nominal_model_that_is_found_again_is_no_model() -> None:
    fitted = NAMED.augmented | {"stribeck_excess_nm": coefficient(0.25, 0.1)}
    arm = nominal_arm(STRIBECK_TERM)
    result = augment_models(Discrepancy(joints=(replace(NAMED, augmented=fitted),)), LOG, arm)
    assert result.model.joints == arm.joints
    assert "stribeck stands twice" in result.lacking[0][1]


def test_an_effect_that_is_no_term_is_left_out_and_said() -> None:
    strange = replace(BIAS, name="poltergeist")
    result = augment_models(Discrepancy(joints=(replace(NAMED, effects=(STRIBECK, strange)),)), LOG, None)
    joint: Any = result.model.joints[0]
    assert joint.values("stribeck")
    assert result.lacking == ((1, "poltergeist is no term of a model, so the augmented one lacks it"),)


def test_numbers_that_a_nominal_term_lacks_are_lacking_in_the_augmented_one() -> None:
    term = FittedTerm("gravity_error", (0.3, 0.1, *([0.0] * 15)))
    stated = [parameter.name for parameter in term.effect.coefficients if not parameter.optional]
    fitted = {"coulomb_nm": coefficient(0.35, 0.1), "viscous_nms_per_rad": coefficient(0.09, 0.1)}
    fitted |= {name: coefficient(float(k), 0.1) for k, name in enumerate(stated)}
    joint = augmented(replace(NONE, joint=1, augmented=fitted), nominal=nominal_arm(term)).joints[0]
    assert joint.values("gravity_error") == (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, *([0.0] * 9))


@pytest.mark.parametrize(("half", "excess"), [(0.02, 0.0), (0.005, None)])
def test_a_number_of_an_effect_that_may_be_its_lower_bound_is_put_there(half: float, excess: float | None) -> None:
    (effect,) = NAMED.effects
    below = replace(effect, parameters={**effect.parameters, "stribeck_excess_nm": coefficient(-0.01, half)})
    result = augment_models(Discrepancy(joints=(replace(NAMED, effects=(below,)),)), LOG, None)
    joint = result.model.joints[0]
    values = None if joint is None else joint.values("stribeck")
    assert (values and values[0]) == excess
