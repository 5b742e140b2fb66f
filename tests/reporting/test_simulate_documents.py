"""Documents of a simulated log and of its truth, against their schemas."""

import json
import math
from hashlib import sha256
from typing import Any

import jsonschema
from friction_audit.reporting.json.document import Document, write_document
from friction_audit.reporting.json.simulate import SimulatedLog, simulate_document, truth_document

from friction_audit.pipeline import Estimate
from friction_audit.reporting.schemas import load_schema

EFFECT = {"joint": 2, "name": "stribeck", "form": None, "parameters": {"excess_nm": 0.2}}
SIMULATED = SimulatedLog(
    scenario="bench",
    seed=4,
    settings={"joints": ({"coulomb_nm": 0.3},), "compensator": {"kind": "fixed", "max_torque_nm": math.inf}},
    effects=[EFFECT],
    sha256=sha256(b"log").hexdigest(),
)


def checked(document: Document) -> Any:
    read = json.loads(write_document(document))
    jsonschema.Draft202012Validator(load_schema(read["schema"].split("/")[1])).validate(read)
    return read


def test_truth() -> None:
    truth = checked(truth_document(SIMULATED))
    assert truth["settings"] == {
        "joints": [{"coulomb_nm": 0.3}],
        "compensator": {"kind": "fixed", "max_torque_nm": None},
    }
    assert truth["effects"] == [EFFECT]
    assert truth["log_sha256"] == SIMULATED.sha256


def test_simulated_log(seven: Estimate) -> None:
    document = checked(simulate_document(SIMULATED, seven.log, "run.mcap", "mcap", left_out=("gravity",)))
    assert document["output"]["samples"] == len(seven.log.t)
    assert document["joint_names"] == list(seven.log.joint_names)
    assert [warning["code"] for warning in document["warnings"]] == ["channels_left_out"]
    assert document["effects"] == [EFFECT]
