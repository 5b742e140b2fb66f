"""Documents keep to their schemas, hold no NaN, and hold the numbers of the result."""

import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, replace
from typing import Any

import jsonschema
import pytest

from friction_audit import __version__
from friction_audit.diagnosis.result import VERDICTS
from friction_audit.io.readers.reader import Topic
from friction_audit.pipeline import Estimate
from friction_audit.reporting.diagnosis import DIAGNOSE
from friction_audit.reporting.diagnosis_words import joint_message
from friction_audit.reporting.documents import KINDS, load_schema, write_document
from friction_audit.reporting.drift import BatchSummary, write_batch_document
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.info import INFO, InfoEntry, summarize_log
from friction_audit.reporting.replay import REPLAY
from friction_audit.reporting.report import REPORT, report_notices
from tests.reporting import batch_by_hand, log_report_by_hand
from tests.reporting.conftest import COULOMB, build_estimate
from tests.reporting.diagnosis_by_hand import FAILED, LIMIT, LOCKED, NAMED, STRIBECK, VERDICTS_BY_HAND, diagnosis

ARM = batch_by_hand.arm()
TWO = batch_by_hand.batch(batch_by_hand.arm(2, 1, dated=False))
BATCHES = (batch_by_hand.batch(ARM), TWO, batch_by_hand.hostile(), batch_by_hand.empty())


def checked(document: dict[str, Any] | Iterable[str]) -> Any:
    """Return the document as a reader of its text gets it, after its schema has been held against it."""
    read = json.loads(write_document(document) if isinstance(document, dict) else "".join(document))
    kind = read["schema"].split("/")[1]
    jsonschema.Draft202012Validator(load_schema(kind)).validate(read)
    assert read["version"] == __version__
    return read


def keys(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the keys of a schema and of those in it; a coefficient is the same everywhere."""
    yield from ((key, one) for key, one in schema.get("properties", {}).items() if key not in ("value", "ci95"))
    parts = (*schema.get("properties", {}).values(), schema.get("items"), schema.get("additionalProperties"))
    for part in (*parts, *schema.get("oneOf", ())):
        yield from keys(part) if part else ()


@pytest.mark.parametrize("kind", KINDS)
def test_schemas_are_schemas_and_describe_every_key(kind: str) -> None:
    schema = load_schema(kind)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert [key for key, one in keys(schema) if "description" not in one and key not in ("schema", "version")] == []


def test_estimate(seven: Estimate) -> None:
    document = checked(ESTIMATE.of(seven, {"topic": None, "time_scale": 1.0}))
    first, still = document["joints"][0], document["joints"][2]
    low, high = first["coulomb_nm"]["ci95"]
    assert low < COULOMB[0] < high
    assert first["regression"]["inertia_kg_m2"] == pytest.approx(0.1, abs=0.01)
    assert still["coulomb_nm"] is still["viscous_nms_per_rad"] is still["condition_number"] is first["reason"] is None
    assert "did not move" in still["reason"]
    assert [(one["code"], one["joint"]) for one in document["warnings"]] == [("not_determined", 3)]
    damaged = checked(ESTIMATE.of(build_estimate(1, damaged=True)))
    assert [warning["code"] for warning in damaged["warnings"]] == ["truncated"]


def test_info(seven: Estimate) -> None:
    topic = Topic(name="/left", type="sensor_msgs/JointState", messages=3, readable=True)
    summary = summarize_log(seven.log, seven.interaction, seven.cycles)
    part = summarize_log(seven.log, None, (), obstacle="gravity is missing")
    failed = InfoEntry(path="b", topics=(topic,), message="two arms")
    document = checked(INFO.json([InfoEntry(path="a", summary=summary), failed, InfoEntry(path="c", summary=part)]))
    log, less = document["logs"]
    assert log["joints"][0]["cycles"] == len(seven.cycles[0].start)
    assert (log["joints"][0]["rejected_cycles"], log["joints"][2]["cycles"], log["gaps"]) == (0, 0, 0)
    assert document["failed"] == [{"path": "b", "topics": [asdict(topic)], "message": "two arms"}]
    assert less["torque"] is less["joints"][0]["cycles"] is None
    assert less["joints"][0]["peak_speed_rad_s"] > 0.5
    assert less["warnings"][-1] == {"code": "no_interaction_torque", "joint": None, "message": "gravity is missing"}


def test_every_verdict_keeps_to_the_schema() -> None:
    joints = (*VERDICTS_BY_HAND, FAILED)
    assert {joint.verdict for joint in joints} == set(VERDICTS)
    for joint, found in zip(joints, checked(DIAGNOSE.of(diagnosis(*joints)))["joints"], strict=True):
        assert (found["verdict"], found["message"]) == (joint.verdict, joint_message(joint))
        assert (found["gap"] is None) == (joint.gap is None)
    found = checked(DIAGNOSE.of(diagnosis()))["joints"]
    assert found[2]["gap"]["shrink"] is found[0]["from_energy"]["viscous_nms_per_rad"] is None
    assert found[4]["detection_limit_nm"] is found[4]["omnibus_p_value"] is found[4]["simulation_gap"] is None
    (effect,) = found[1]["effects"]
    assert effect["alternatives"] == ["asymmetric_coulomb"]
    assert "rest" in effect["decide"]
    assert found[3]["checks"] == [{"code": "line", "along": "time", "share": 0.3, "frequency": 13.0}]


def test_a_joint_with_an_effect() -> None:
    lost = replace(STRIBECK, name="warm_up", grade="negligible", not_identifiable=("stribeck_exponent",))
    document = checked(DIAGNOSE.of(diagnosis(replace(NAMED, negligible=(lost,), detection_limit_nm=math.inf))))
    (found,) = document["joints"]
    (effect,), (other,) = found["effects"], found["negligible"]
    assert effect["parameters"] == {"stribeck_excess_nm": 0.15, "stribeck_speed_rad_s": 0.1, "stribeck_exponent": 2.0}
    assert effect["parameters_ci95"]["stribeck_excess_nm"] == pytest.approx([0.14, 0.16])
    assert effect["parameters_ci95"]["stribeck_exponent"] == other["parameters_ci95"]["stribeck_exponent"] == [None] * 2
    assert (other["not_identifiable"], other["parameters"]["stribeck_exponent"]) == (["stribeck_exponent"], None)
    assert effect["evidence"][1] == {"name": "warm_up", "two_ln_bayes_factor": 41.3, "correlation": 0.31}
    assert (found["gap"]["shrink"], found["gap"]["held_out_cycles"]) == (pytest.approx(0.04 / 0.041), LOCKED)
    assert found["simulation_gap"] == {"before": 0.052, "after": 0.013, "unit": "rad/s"}
    assert found["profiles"][0]["curve"]["forwards_nm"] == [0.05, 0.0, None]
    assert [profile["curve"] is None for profile in found["profiles"]] == [False, True]
    assert {"code": "standstill", "joint": 1, "message": LIMIT} in document["warnings"]
    assert found["detection_limit_nm"] is None


@pytest.mark.parametrize("summary", BATCHES, ids=("plain", "two sessions", "hostile", "empty"))
def test_a_batch(summary: BatchSummary) -> None:
    document = checked(write_batch_document(summary))
    assert len(document["sessions"]) == len(summary.sessions)
    assert [one["path"] for one in document["failed"]] == [one.path for one in summary.failed]


def test_what_drifts_and_when() -> None:
    document = checked(write_batch_document(batch_by_hand.batch(ARM, batch_by_hand.arm(3, robot="panda-2"))))
    by_joint = {joint["joint"]: joint for joint in document["joints"] if joint["robot"] == "panda-1"}
    assert [joint for joint, one in by_joint.items() if one["drift"]] == [2, 5]
    assert (by_joint[2]["change_points"], by_joint[1]["change_points"]) == ([13], [])
    assert by_joint[5]["coulomb_trend_nm_per_session"]["value"] == pytest.approx(0.00267)
    assert (by_joint[7]["coulomb_trend_nm_per_session"], by_joint[7]["verdict"]) == (None, "not testable")
    coulomb = by_joint[2]["coefficients"]["coulomb_nm"]
    assert coulomb["change_points"][0]["ci95"] == [12, 14]
    assert [point["session"] for point in coulomb["control"] if point["outside"]] == list(range(13, 25))
    first = document["robots"][0]
    assert [one["session"] for one in document["sessions"]] == [*range(1, 25), 1, 2, 3]
    assert first["left_out"] == [{"session": 9, "reason": "payload 0.7 kg, the reference had none"}]
    assert first["reference"] == [1, 2, 3, 4, 5]
    assert document["sessions"][1]["start"] == "2026-03-05T03:00:00.000Z"


def test_a_report_holds_the_documents_of_its_parts() -> None:
    found: Any = log_report_by_hand.report()
    document = checked(REPORT.json(found, found.unit))
    parts = (ESTIMATE.of(found.estimate), DIAGNOSE.of(found.diagnosis), REPLAY.of(found.replay))
    for name, whole in zip(("estimate", "diagnose", "replay"), map(checked, parts), strict=True):
        assert document[name] == {key: whole[key] for key in document[name]}
        assert "joints" in document[name]
    assert document["settings"]["replay"] == whole["settings"]["replay"]
    assert [one["code"] for one in document["warnings"]] == [one.code for one in report_notices(found)]
