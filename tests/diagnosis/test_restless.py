"""What follows nothing of the motion decides where it is large, and is told."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.restless import find_restless
from friction_audit.diagnosis.result import Vibration
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint

OVER = 1.02
BARE = moved_joint(duration_s=60.0)
NOISE = 0.05 * np.random.default_rng(3).standard_normal(len(BARE.t))


def with_torque(torque: Float) -> JointData:
    return replace(BARE, torque=BARE.torque + NOISE + torque)


def ground(torque: Float) -> Ground:
    return make_ground(with_torque(torque), None, 0)


def never(_vibration: Vibration) -> bool:
    return False


def always(_vibration: Vibration) -> bool:
    return True


def test_noise_of_a_sensor_does_not_decide() -> None:
    found = find_restless(ground(np.zeros(len(BARE.t))), [], [], OVER, never)
    assert not found.decides
    assert found.scatter is None
    assert found.phrases == ()


def test_a_hum_decides_unless_it_is_the_ringing_of_what_was_named() -> None:
    hum = ground(0.02 * np.sqrt(2.0) * np.sin(2.0 * np.pi * 7.0 * BARE.t))
    found = find_restless(hum, [], [], OVER, never)
    assert found.decides
    assert found.vibration is not None
    assert found.vibration.frequency_hz == pytest.approx(7.0, abs=0.5)
    assert "a vibration at 7 Hz" in found.phrases[0]
    assert not find_restless(hum, [], [], OVER, always).decides


def test_what_comes_round_with_the_path_decides() -> None:
    path = np.cumsum(np.abs(BARE.dq)) * BARE.step_s
    found = find_restless(ground(0.05 * np.sin(path / 0.4)), [], [], OVER, never)
    assert found.decides
    assert any("of the path travelled" in phrase for phrase in found.phrases)


def test_friction_that_comes_round_with_the_path_decides() -> None:
    path = np.cumsum(np.abs(BARE.dq)) * BARE.step_s
    found = find_restless(ground(0.05 * np.sign(BARE.dq) * np.sin(path / 0.4)), [], [], OVER, never)
    assert found.decides
    (phrase,) = (phrase for phrase in found.phrases if "friction" in phrase and "with a period of" in phrase)
    assert f"period of {2.0 * np.pi * 0.4:.2g}" in phrase


def test_friction_that_flips_decides() -> None:
    level = np.random.default_rng(1).integers(0, 2, 60)[np.minimum(BARE.t.astype(int), 59)] - 0.5
    found = find_restless(ground(0.08 * level * np.sign(BARE.dq)), [], [], OVER, never)
    assert found.decides
    assert found.scatter is not None
    assert found.scatter.rms_nm == pytest.approx(0.04, rel=0.4)


def test_what_is_small_beside_the_noise_does_not_decide() -> None:
    small = ground(0.002 * np.sin(2.0 * np.pi * 7.0 * BARE.t))
    assert not find_restless(small, [], [], OVER, never).decides
