"""Whose model is known."""

from dataclasses import replace

import numpy as np

from friction_audit.joint_log import JointLog, Source
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.torque_source import known_arm
from tests.synthetic_interaction import choice


def log(robot: str, joints: int = 7) -> JointLog:
    t = np.arange(3, dtype=np.float64)
    still = np.zeros((3, joints))
    names = tuple(f"joint{k}" for k in range(1, joints + 1))
    source = Source(path="log", sha256="0", format="parquet", robot=robot)
    return JointLog(t=t, q=still, dq=still.copy(), tau_J=still.copy(), joint_names=names, source=source)


def test_a_log_that_names_a_panda_or_a_user_who_does() -> None:
    assert known_arm(log("panda"), TorqueSettings(), choice()) is not None
    assert known_arm(log("unknown"), TorqueSettings(robot="panda"), choice()) is not None


def test_an_arm_that_the_torque_was_made_with() -> None:
    used = replace(choice(), robot="panda")
    assert known_arm(log("unknown"), TorqueSettings(), used) is not None


def test_strangers_have_none() -> None:
    assert known_arm(log("unknown"), TorqueSettings(), choice()) is None
    assert known_arm(log("fr3"), TorqueSettings(), choice()) is None
    assert known_arm(log("panda"), TorqueSettings(robot="none"), choice()) is None
    assert known_arm(log("panda", joints=1), TorqueSettings(), choice()) is None
