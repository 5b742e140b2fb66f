"""The document of a diagnosis keeps to its schema and holds no NaN, whatever the verdict."""

from dataclasses import replace

import pytest
from friction_audit.reporting.json.diagnose import diagnose_document

from friction_audit.diagnosis.result import VERDICTS, JointDiscrepancy
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import ArmModel, simple_model
from tests.reporting.diagnosis_by_hand import FAILED, LOCKED, NAMED, VERDICTS_BY_HAND, diagnosis
from tests.reporting.test_documents import checked


def test_every_verdict_has_a_joint_by_hand() -> None:
    assert {joint.verdict for joint in (*VERDICTS_BY_HAND, FAILED)} == set(VERDICTS)


@pytest.mark.parametrize("joint", [*VERDICTS_BY_HAND, FAILED], ids=lambda joint: joint.verdict)
def test_each_verdict_keeps_to_the_schema(joint: JointDiscrepancy) -> None:
    (told,) = checked(diagnose_document(diagnosis((joint,))))["joints"]
    assert told["verdict"] == joint.verdict
    assert told["message"] == joint.message
    assert (told["gap"] is None) == (joint.gap is None)


def test_the_effect_has_its_numbers_units_in_the_names() -> None:
    (told,) = checked(diagnose_document(diagnosis((NAMED,))))["joints"]
    (effect,) = told["effects"]
    assert effect["parameters"] == {"stribeck_excess_nm": 0.15, "stribeck_speed_rad_s": 0.1, "stribeck_exponent": 2.0}
    assert effect["parameters_ci95"]["stribeck_excess_nm"] == pytest.approx([0.14, 0.16])
    assert effect["parameters_ci95"]["stribeck_exponent"] == [None, None]
    assert (effect["gap_before_nm"], effect["gap_after_nm"]) == (0.061, 0.021)
    assert effect["decide"] is None
    assert effect["curve"]["backwards_nm"] == [-0.05, 0.0, 0.01]
    assert effect["evidence"][1] == {"name": "warm_up", "delta_bic": 41.3, "correlation": 0.31}


def test_gaps_are_those_of_the_locked_cycles() -> None:
    (told,) = checked(diagnose_document(diagnosis((NAMED,))))["joints"]
    assert told["gap"]["baseline_rms_nm"] == 0.061
    assert told["gap"]["final_rms_nm"] == 0.021
    assert told["gap"]["noise_floor_rms_nm"] == 0.02
    assert told["gap"]["shrink"] == pytest.approx(0.04 / 0.041)
    assert told["gap"]["held_out_cycles"] == LOCKED
    assert told["simulation_gap"] == {"before": 0.052, "after": 0.013, "unit": "rad/s"}


def test_numbers_that_nobody_knows_are_null() -> None:
    joints = checked(diagnose_document(diagnosis()))["joints"]
    assert joints[2]["gap"]["shrink"] is None
    assert joints[0]["from_energy"]["viscous_nms_per_rad"] is None
    assert joints[4]["detection_limit_nm"] is joints[4]["omnibus_p_value"] is joints[4]["simulation_gap"] is None


def test_the_most_telling_axis_has_its_curve() -> None:
    (told,) = checked(diagnose_document(diagnosis((NAMED,))))["joints"]
    assert told["profiles"][0]["curve"]["forwards_nm"] == [0.05, 0.0, None]
    assert [profile["curve"] is None for profile in told["profiles"]] == [False, True]


def test_a_vibration_is_told_where_there_is_one() -> None:
    joints = checked(diagnose_document(diagnosis()))["joints"]
    assert joints[3]["vibration"] == {"frequency_hz": 13.0, "low_hz": 11.0, "high_hz": 15.5, "rms_nm": 0.04}
    assert joints[0]["vibration"] is None


def test_alternatives_come_with_what_decides() -> None:
    (effect,) = checked(diagnose_document(diagnosis()))["joints"][1]["effects"]
    assert effect["alternatives"] == ["asymmetric_coulomb"]
    assert effect["alternatives_together"] == []
    assert "rest" in effect["decide"]


def test_settings_repeat_what_was_asked_the_declared_model_too() -> None:
    model = ArmModel(names=("a",), joints=(simple_model(inertia_kg_m2=1, coulomb_nm=2, viscous_nms_per_rad=3),))
    asked = DiagnosisSettings(candidates=("stribeck",), alpha=0.01, seed=4, model=model)
    document = checked(diagnose_document(diagnosis((NAMED,), asked), {"topic": None}))
    settings = document["settings"]["diagnosis"]
    assert (settings["candidates"], settings["alpha"], settings["seed"]) == (["stribeck"], 0.01, 4)
    assert settings["model"]["joints"][0]["terms"][0] == {"name": "coulomb", "values": [2]}
    assert checked(diagnose_document(diagnosis()))["settings"]["diagnosis"]["model"] is None


def test_data_that_are_limited_are_findings_and_warnings() -> None:
    document = checked(diagnose_document(diagnosis()))
    assert document["joints"][0]["findings"][1]["verdict"] == "limit"
    assert {"code": "standstill", "joint": 1, "message": NAMED.findings[1].message} in document["warnings"]


def test_a_gap_that_is_not_to_be_closed_has_no_share() -> None:
    joint = replace(NAMED, detection_limit_nm=float("inf"))
    assert checked(diagnose_document(diagnosis((joint,))))["joints"][0]["detection_limit_nm"] is None
