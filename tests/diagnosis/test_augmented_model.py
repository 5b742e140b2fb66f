"""The augmented model holds the nominal terms as fitted together with the effects, and the effects."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from friction_audit.diagnosis.augmented_model import augment_models, gap_in_motion, simulate_cycles
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance, simple_model
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution
from tests.dynamics.joints import simulate
from tests.effects.joint_data_by_hand import joint_of
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import BIAS, DATA_FAULT, NAMED, NONE, STRIBECK, coefficient

LOG = build_estimate(3, count=4, rate=100.0).log
STRIBECK_TERM = FittedTerm("stribeck", (0.2, 0.05, 1.0))


def augmented(*joints: JointDiagnosis, nominal: ArmModel | None = None) -> Any:
    model, lacking = augment_models(joints, LOG, nominal)
    assert lacking == []
    return model


def nominal_arm(*terms: FittedTerm) -> ArmModel:
    joint = JointModel(inertia_kg_m2=0.5, terms=(FittedTerm("coulomb", (0.4,)), FittedTerm("viscous", (0.1,)), *terms))
    return ArmModel(names=LOG.joint_names, joints=(joint,) * 3)


def test_a_missing_effect_is_a_term_the_rest_is_as_fitted_with_it_and_its_origin_is_stated() -> None:
    joint = augmented(NAMED).joints[0]
    assert (joint.inertia_kg_m2, joint.values("coulomb"), joint.values("viscous")) == (0.3, (0.30,), (0.07,))
    assert joint.values("stribeck") == (0.15, 0.1, 2.0)
    assert joint.provenance == Provenance(method="diagnose", log="run 1.csv", sha256="0" * 64, cycles=30)


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
    model, lacking = augment_models((wrong,), LOG, None)
    assert model.joints == (None, None, None)
    (lack,) = lacking
    assert lack.joint == 1
    assert "viscous_nms_per_rad = -0.01; expected a number from 0" in lack.numbers["error"]
    maybe = {**NAMED.augmented, "viscous_nms_per_rad": coefficient(-0.01, 0.02)}
    assert augmented(replace(NAMED, augmented=maybe)).joints[0].values("viscous") == (0.0,)


def test_a_term_of_the_nominal_model_that_is_found_again_is_no_model() -> None:
    fitted = NAMED.augmented | {"stribeck_excess_nm": coefficient(0.25, 0.1)}
    arm = nominal_arm(STRIBECK_TERM)
    model, lacking = augment_models((replace(NAMED, augmented=fitted),), LOG, arm)
    assert model.joints == arm.joints
    assert "stribeck stands twice" in lacking[0].numbers["error"]


def test_an_effect_that_is_no_term_is_left_out_and_said() -> None:
    strange = replace(BIAS, name="poltergeist")
    model, lacking = augment_models((replace(NAMED, effects=(STRIBECK, strange)),), LOG, None)
    joint: Any = model.joints[0]
    assert joint.values("stribeck")
    assert lacking == [Caution("no_term", 1, {"name": "poltergeist"})]


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
    joint = augment_models((replace(NAMED, effects=(below,)),), LOG, None)[0].joints[0]
    values = None if joint is None else joint.values("stribeck")
    assert (values and values[0]) == excess


# The gap in motion: none for the model that made the motion, that of what is missing for another.

NOMINAL = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
AUGMENTED = replace(NOMINAL, terms=(*NOMINAL.terms, FittedTerm("stribeck", (0.15, 0.1, 2.0))))


CYCLES = np.array([4, 9])


@cache
def moved() -> JointData:
    """A joint that the augmented model moved under a sinusoidal torque of 2 s, a cycle per half period."""
    t = np.arange(4400) / 400.0
    torque = (0.6 + 0.02 * t) * np.sin(np.pi * t)
    motion = simulate(AUGMENTED, t, torque)
    return data_of(t, torque, motion.q, motion.dq, np.gradient(motion.dq, t))


def data_of(t: Float, torque: Float, q: Float, dq: Float, ddq: Float) -> JointData:
    return joint_of(t, q, dq, ddq, torque, cycle=np.floor(t).astype(np.int64), dead_speed_rad_s=1e-3)


def subject_of(data: JointData) -> Subject:
    return Subject(data=data, number=1, name="joint1", findings=(), from_energy={})


def diagnosed(viscous_nms_per_rad: float = 0.07) -> JointDiagnosis:
    numbers = {"inertia_kg_m2": 0.3, "coulomb_nm": 0.3, "viscous_nms_per_rad": 0.07}
    simple = {name: Coefficient.around(one, 0.0) for name, one in numbers.items()}
    wrong = Coefficient.around(viscous_nms_per_rad, 0.0)
    return JointDiagnosis(
        joint=1, name="joint1", verdict="named", effects=(STRIBECK,), nominal=simple,
        augmented=simple | {"viscous_nms_per_rad": wrong},
    )  # fmt: skip


def test_the_model_that_made_the_motion_leaves_nothing_from_the_measured_start_of_every_cycle() -> None:
    data = moved()
    gap: Any = simulate_cycles(NOMINAL, AUGMENTED, data, CYCLES)
    assert gap.before > 0.05
    assert gap.after < 0.01 * gap.before
    assert list(np.flatnonzero(np.isnan(gap.t))) == [400]
    assert gap.t[[0, 401]] == pytest.approx([4.0, 9.0])
    for signal in (gap.nominal, gap.augmented, gap.measured):
        assert signal[[0, 401]] == pytest.approx(data.dq[[1600, 3600]])
        assert np.array_equal(np.isnan(signal), np.isnan(gap.t))
    same: Any = gap_in_motion(diagnosed(), subject_of(data), CYCLES)
    assert (same.before, same.after) == (gap.before, gap.after)


def test_by_hand_a_torque_that_is_wrong_adds_up() -> None:
    """A constant 0.03 N m too much for 1 s at 0.3 kg m^2 is 0.1 rad/s at the end: 0.1 / sqrt(3) on average."""
    t = np.arange(0.0, 4.0, 0.0025)
    model = JointModel(inertia_kg_m2=0.3)
    data = data_of(t, np.full(len(t), 0.3), 0.5 * t**2 + t, 1.0 + t, np.ones(len(t)))
    wrong = JointModel(inertia_kg_m2=0.3, terms=(FittedTerm("offset", (-0.03,)),))
    gap: Any = simulate_cycles(wrong, model, data, np.array([1]))
    assert gap.before == pytest.approx(0.1 / np.sqrt(3.0), rel=5e-3)
    assert gap.after < 1e-9


def test_cycles_with_a_gap_are_left_out() -> None:
    valid = moved().valid.copy()
    valid[1700] = False
    gapped = replace(moved(), valid=valid)
    gap: Any = simulate_cycles(NOMINAL, AUGMENTED, gapped, CYCLES)
    assert gap.t[0] == pytest.approx(9.0)
    assert simulate_cycles(NOMINAL, AUGMENTED, gapped, np.array([4])) is None


def test_a_joint_whose_inertia_was_taken_out_needs_it_back() -> None:
    light = replace(moved(), torque=moved().torque - 0.2999 * moved().ddq)
    nominal, found = (replace(model, inertia_kg_m2=1e-4) for model in (NOMINAL, AUGMENTED))
    assert simulate_cycles(nominal, found, light, CYCLES) is None
    gap: Any = simulate_cycles(nominal, found, light, CYCLES, known_inertia_kg_m2=0.2999)
    assert gap.after < 0.1 * gap.before


def test_a_model_that_cannot_be_simulated_has_no_gap_in_motion() -> None:
    runaway = replace(NOMINAL, terms=(*NOMINAL.terms, FittedTerm("nonlinear_viscous", (-40.0, 1.0, 0.1, 0.0))))
    assert simulate_cycles(NOMINAL, runaway, moved(), CYCLES) is None
    assert gap_in_motion(diagnosed(-0.01), subject_of(moved()), CYCLES) is None
