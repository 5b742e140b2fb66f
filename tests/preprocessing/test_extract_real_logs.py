"""Measured logs of real arms; they are not part of this project: FRICTION_AUDIT_REAL_LOGS names their folder."""

import os
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyarrow import parquet
from rosbags.typesys import Stores, get_typestore

from friction_audit.joint_log import Float, JointLog, Source
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.interaction_torque import extract_interaction
from friction_audit.preprocessing.settings import TorqueSettings

FOLDER = os.environ.get("FRICTION_AUDIT_REAL_LOGS")
pytestmark = pytest.mark.skipif(FOLDER is None, reason="FRICTION_AUDIT_REAL_LOGS is not set")

PUBLISHED_COULOMB_NM = np.array([0.2450, 0.1523, 0.1827, 0.3591, 0.2669, 0.1658, 0.2109])
"""Classical identification on this very trajectory, Gaz et al. 2019, supplementary Table III."""


def joint_log(t: Float, robot: str, **channels: Float) -> JointLog:
    arrays: dict[str, Any] = {name: np.asfortranarray(array) for name, array in channels.items()}
    names = tuple(f"panda_joint{number}" for number in range(1, 8))
    source = Source(path="real", sha256="", format="test", robot=robot)
    return JointLog(t=t - t[0], joint_names=names, source=source, **arrays)


def excitation(robot: str) -> JointLog:
    """A Panda moved by its own motors, 21 s, 1 kHz."""
    table = parquet.read_table(Path(str(FOLDER), "marcocognetti+FrankaEmikaPandaDynModel", "panda_excitation.parquet"))
    channels = {
        name: np.column_stack([table[f"{name}_{joint}"].to_numpy() for joint in range(1, 8)])
        for name in ("q", "dq", "tau_J")
    }
    return joint_log(table["time"].to_numpy(), robot, **channels)


def one_way_csv() -> JointLog:
    """A Panda with a flexible beam, one move of a second."""
    rows = np.loadtxt(Path(str(FOLDER), "shamilmamedov+beam_handling", "OCP_T3_0.81s.csv"), delimiter=",", skiprows=2)
    columns = {"q": 2, "dq": 16, "tau_J": 30, "tau_ext_hat_filtered": 37}
    return joint_log(
        rows[:, 0] / 1000, "panda", **{name: rows[:, first : first + 7] for name, first in columns.items()}
    )


def bag_at_30_hz() -> JointLog:
    """A Panda moved by its own motors, 24 s, 30 Hz."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    path = Path(str(FOLDER), "unisa-acg+inverse-dynamics-solver", "panda_exciting_trajectory.db3")
    with sqlite3.connect(path) as database:
        rows = database.execute("select data from messages order by timestamp").fetchall()
    messages: list[Any] = [store.deserialize_cdr(row[0], "sensor_msgs/msg/JointState") for row in rows]
    order = [list(messages[0].name).index(f"fer_joint{number}") for number in range(1, 8)]
    stamps = np.array([message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec for message in messages])
    fields = {"q": "position", "dq": "velocity", "tau_J": "effort"}
    channels = {
        name: np.array([getattr(message, field) for message in messages])[:, order] for name, field in fields.items()
    }
    return joint_log(stamps, "panda", **channels)


def coulomb(interaction: Interaction) -> Float:
    """Regress F_m on sgn(dq), dq, 1, sin q and cos q where the joint moves."""
    found = []
    for joint in range(7):
        dq, q = interaction.dq[:, joint], interaction.q[:, joint]
        moving = np.abs(dq) > 0.05
        columns = np.column_stack([np.sign(dq), dq, np.ones_like(dq), np.sin(q), np.cos(q)])[moving]
        found.append(np.linalg.lstsq(columns, interaction.torque[moving, joint], rcond=None)[0][0])
    return np.array(found)


def test_the_sign_is_proved_on_all_seven_joints_and_the_model_is_right() -> None:
    settings = TorqueSettings(drive="robot", gravity="model", inertia="model", robot="panda")
    found = extract_interaction(excitation("unknown"), settings)
    assert [one.verdict for one in found.choice.sign_evidence] == ["rises"] * 7
    assert [caution.code for caution in found.warnings] == ["dq_late"]
    error = np.abs(coulomb(found) - PUBLISHED_COULOMB_NM)
    assert error.max() < 0.10
    assert error[4:].max() < 0.06


def test_auto_finds_out_that_the_arm_moved_by_itself() -> None:
    found = extract_interaction(excitation("panda"), TorqueSettings())
    assert (found.choice.drive, found.choice.inertia, found.choice.sign_turned) == ("robot", "model", True)
    assert found.choice.sign_proved
    assert [caution.code for caution in found.warnings] == ["dq_late", "sign_turned"]


def test_one_way_motion_proves_no_sign() -> None:
    found = extract_interaction(one_way_csv(), TorqueSettings())
    assert not found.choice.sign_proved
    assert [caution.code for caution in found.warnings] == ["dq_late", "sign_unproved"]
    assert np.isfinite(found.torque).all()


def test_a_log_at_30_hz() -> None:
    found = extract_interaction(bag_at_30_hz(), TorqueSettings())
    assert (found.choice.drive, found.choice.sign_proved) == ("robot", True)
    assert coulomb(found)[6] == pytest.approx(0.25, abs=0.05)


def test_with_gravity_still_inside_the_arm_that_moves_by_itself_is_noticed_too() -> None:
    found = extract_interaction(excitation("unknown"), TorqueSettings())
    assert (found.choice.drive, found.choice.gravity) == ("robot", "none")
    assert found.choice.sign_proved
    assert {"gravity_in_torque", "sign_turned"} <= {caution.code for caution in found.warnings}
