"""What the program says about measured logs of real robots.

The logs are not part of the project; FRICTION_AUDIT_REAL_LOGS names the folder that holds them.
"""

import json
import os
from pathlib import Path

import pytest

from friction_audit.cli import main

REAL = os.environ.get("FRICTION_AUDIT_REAL_LOGS")
pytestmark = pytest.mark.skipif(REAL is None, reason="FRICTION_AUDIT_REAL_LOGS is not set")

EXCITATION = "marcocognetti+FrankaEmikaPandaDynModel/panda_excitation.parquet"
AT_REST = "sebtiburzio+dlo_parameter_id/calib_0108.bag"
ONE_WAY = "shamilmamedov+beam_handling/OCP_T3_0.81s.csv"
SLOW_RATE = "unisa-acg+inverse-dynamics-solver/panda_exciting_trajectory.db3"

PUBLISHED_COULOMB_NM = (0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 0.211)
"""Classical identification of Gaz et al. (2019), supplementary table III, on the excitation log."""


def run(capsys: pytest.CaptureFixture[str], *argv: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as caught:
        main(list(argv))
    captured = capsys.readouterr()
    return int(caught.value.code or 0), captured.out, captured.err


def path(name: str) -> str:
    return str(Path(REAL or "") / name)


def test_the_excitation_log_agrees_with_the_published_identification(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "estimate", path(EXCITATION), "--drive", "robot", "--robot", "panda", "--json")
    document = json.loads(out)
    assert code == 0
    for joint, published in zip(document["joints"], PUBLISHED_COULOMB_NM, strict=True):
        bound = 0.06 if joint["joint"] >= 5 else 0.10
        assert abs(joint["coulomb_nm"]["value"] - published) < bound, joint["name"]
    choice = document["settings"]["torque_chosen"]
    assert choice["sign_proved"]
    assert [one["verdict"] for one in choice["sign_evidence"]] == ["rises"] * 7


def test_an_arm_at_rest_has_no_answer(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "estimate", path(AT_REST))
    assert code == 4
    assert "did not move: " in err


def test_one_way_motion_has_no_answer(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "estimate", path(ONE_WAY))
    assert code == 4
    assert "no closed energy cycle" in err


def test_the_bag_at_30_hz_reads_warns_and_estimates_joint_7(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "estimate", path(SLOW_RATE), "--json")
    document = json.loads(out)
    assert code == 0
    assert "low_rate" in [warning["code"] for warning in document["warnings"]]
    assert abs(document["joints"][6]["coulomb_nm"]["value"] - 0.25) < 0.05
