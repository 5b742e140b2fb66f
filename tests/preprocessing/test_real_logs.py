"""Measured logs of real arms; they are not part of this project: FRICTION_AUDIT_REAL_LOGS names their folder."""

import os
from pathlib import Path

import numpy as np
import pytest

from friction_audit import read_log
from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.interaction_torque import extract_interaction
from friction_audit.preprocessing.settings import TorqueSettings

FOLDER = os.environ.get("FRICTION_AUDIT_REAL_LOGS")
pytestmark = pytest.mark.skipif(FOLDER is None, reason="FRICTION_AUDIT_REAL_LOGS is not set")
# Classical identification on this very trajectory, Gaz et al. 2019, supplementary Table III.
PUBLISHED_COULOMB_NM = np.array([0.2450, 0.1523, 0.1827, 0.3591, 0.2669, 0.1658, 0.2109])


def real(*parts: str) -> JointLog:
    return read_log(Path(str(FOLDER), *parts))


def excitation() -> JointLog:
    """A Panda moved by its own motors, 21 s, 1 kHz; the file does not name it."""
    return real("marcocognetti+FrankaEmikaPandaDynModel", "panda_excitation.parquet")


def coulomb(interaction: Interaction) -> Float:
    """Regress F_m on sgn(dq), dq, 1, sin q and cos q where the joint moves."""
    found = []
    for joint in range(7):
        dq, q = interaction.dq[:, joint], interaction.q[:, joint]
        moving = np.abs(dq) > 0.05
        columns = np.column_stack([np.sign(dq), dq, np.ones_like(dq), np.sin(q), np.cos(q)])[moving]
        found.append(np.linalg.lstsq(columns, interaction.torque[moving, joint], rcond=None)[0][0])
    return np.array(found)


def codes(interaction: Interaction) -> set[str]:
    return {caution.code for caution in interaction.warnings}


def test_the_sign_is_proved_on_all_seven_joints_and_the_model_is_right() -> None:
    found = extract_interaction(excitation(), TorqueSettings(drive="robot", robot="panda"))
    assert [one.verdict for one in found.choice.sign_evidence] == ["rises"] * 7
    assert codes(found) == {"dq_late"}
    error = np.abs(coulomb(found) - PUBLISHED_COULOMB_NM)
    assert error.max() < 0.10
    assert error[4:].max() < 0.06


@pytest.mark.parametrize(("robot", "gravity"), [("panda", "model"), ("none", "in-torque")])
def test_auto_finds_out_that_the_arm_moved_by_itself(robot: str, gravity: str) -> None:
    found = extract_interaction(excitation(), TorqueSettings(robot=robot))
    assert (found.choice.drive, found.choice.gravity, found.choice.sign_turned) == ("robot", gravity, True)
    assert found.choice.sign_proved
    assert {"dq_late", "sign_turned"} <= codes(found)
    assert ("gravity_in_torque" in codes(found)) == (gravity == "in-torque")


def test_one_way_motion_proves_no_sign() -> None:
    """A Panda with a flexible beam, one move of a second."""
    found = extract_interaction(real("shamilmamedov+beam_handling", "OCP_T3_0.81s.csv"), TorqueSettings(robot="panda"))
    assert not found.choice.sign_proved
    assert "sign_unproved" in codes(found)
    assert np.isfinite(found.torque).all()


def test_a_log_at_30_hz() -> None:
    """A Panda moved by its own motors, 24 s."""
    log = real("unisa-acg+inverse-dynamics-solver", "panda_exciting_trajectory.db3")
    found = extract_interaction(log, TorqueSettings(robot="panda"))
    assert (found.choice.drive, found.choice.sign_proved) == ("robot", True)
    assert coulomb(found)[6] == pytest.approx(0.25, abs=0.05)
