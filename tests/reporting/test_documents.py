"""Documents keep to their schemas, hold no NaN, and say what the result says."""

import csv
import io
import json
import math
from dataclasses import asdict

import jsonschema
import numpy as np
import pytest
from friction_audit.reporting.json.document import Document, convert_document, plot_document, to_json, write_document
from friction_audit.reporting.json.estimate import InfoEntry, TopicSummary, estimate_document, info_document
from friction_audit.reporting.log_summary import summarize_log
from friction_audit.reporting.tables.of_estimate import HEADER, history_csv

from friction_audit import __version__
from friction_audit.pipeline import Estimate
from friction_audit.reporting.schemas import KINDS, load_schema
from tests.reporting.conftest import COULOMB, EstimateFactory


def checked(document: Document) -> Document:
    """Return the document as a reader of its text gets it, after its schema has been held against it."""
    read: Document = json.loads(write_document(document))
    kind = read["schema"].split("/")[1]
    jsonschema.Draft202012Validator(load_schema(kind)).validate(read)
    assert read["version"] == __version__
    return read


@pytest.mark.parametrize("kind", KINDS)
def test_schemas_are_schemas(kind: str) -> None:
    jsonschema.Draft202012Validator.check_schema(load_schema(kind))


def test_estimate(seven: Estimate) -> None:
    document = checked(estimate_document(seven, {"topic": None, "time_scale": 1.0}))
    first, still = document["joints"][0], document["joints"][2]
    assert first["coulomb_nm"] == {"value": COULOMB[0], "ci95": pytest.approx([0.97 * COULOMB[0], 1.03 * COULOMB[0]])}
    assert first["regression"]["inertia_kg_m2"] == 0.1
    assert first["reason"] is None
    assert first["offset_nm"] is None
    assert len(first["history"]) == first["cycles"]
    assert first["history"][0]["coulomb_nm"] is None
    assert still["coulomb_nm"] is still["viscous_nms_per_rad"] is still["condition_number"] is None
    assert "does not move" in still["reason"]
    assert document["source"]["joints"] == 7
    assert document["settings"]["cycles_per_point"] == 20
    assert document["settings"]["torque_chosen"]["drive"] == "hand"
    assert document["settings"]["cycles"]["initiation_rad_s"] == 0.2
    assert [warning["code"] for warning in document["warnings"]] == ["gravity_absent", "still"]


def test_findings_of_the_reader_come_first_among_the_warnings(estimate_of: EstimateFactory) -> None:
    document = checked(estimate_document(estimate_of(1, damaged=True)))
    assert [warning["code"] for warning in document["warnings"]] == ["truncated", "gravity_absent"]


def test_plot(seven: Estimate) -> None:
    document = checked(plot_document(seven, [("energy", None, "energy.png"), ("energy", 2, "energy-joint2.png")]))
    assert [figure["joint"] for figure in document["figures"]] == [None, 2]


def test_convert(seven: Estimate) -> None:
    document = checked(convert_document(seven.log, "out.csv", "csv-long", ("temperature",)))
    assert document["output"]["dialect"] == "csv-long"
    assert "no place for temperature" in document["warnings"][0]["message"]


def test_info(seven: Estimate) -> None:
    topic = TopicSummary(name="/left", type="sensor_msgs/JointState", messages=3, readable=True)
    summary = summarize_log(seven.log, seven.interaction, seven.cycles)
    entries = [InfoEntry(path="a", summary=summary), InfoEntry(path="b", topics=(topic,), message="two arms")]
    document = checked(info_document(entries))
    log = document["logs"][0]
    assert log["channels"] == {"q": "q_{i}", "dq": "dq_{i}"}
    assert log["torque"]["drive"] == "hand"
    assert log["joints"][0]["cycles"] == len(seven.cycles.of_joint(0).joint)
    assert log["joints"][0]["rejected_cycles"] == 1
    assert log["joints"][2]["cycles"] == 0
    assert log["gaps"] == 0
    assert document["failed"] == [{"path": "b", "topics": [asdict(topic)], "message": "two arms"}]


def test_info_goes_as_far_as_the_log_allows(seven: Estimate) -> None:
    summary = summarize_log(seven.log, None, None, obstacle="gravity is missing")
    log = checked(info_document([InfoEntry(path="a", summary=summary)]))["logs"][0]
    assert log["torque"] is None
    assert log["joints"][0]["cycles"] is None
    assert log["joints"][0]["peak_speed_rad_s"] > 0.5
    assert log["warnings"][-1] == {"code": "no_interaction_torque", "joint": None, "message": "gravity is missing"}


def test_history_is_tidy(seven: Estimate) -> None:
    rows = list(csv.DictReader(io.StringIO(history_csv(seven))))
    assert tuple(rows[0]) == HEADER
    assert len(rows) == sum(joint.cycles for joint in seven.friction.joints)
    assert {row["joint"] for row in rows} == {"1", "2", "4", "5", "6", "7"}
    assert rows[0]["coulomb_nm"] == ""
    assert float(rows[1]["coulomb_nm"]) == pytest.approx(COULOMB[0], rel=0.2)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (math.nan, None),
        (np.array([1.0, np.inf]), [1.0, None]),
        (np.int64(3), 3),
        ({"a": (1, np.nan)}, {"a": [1, None]}),
        (True, True),
    ],
)
def test_values_become_what_json_knows(value: object, expected: object) -> None:
    assert to_json(value) == expected
