"""A vibration of the structure is found where it is; noise of any colour, and what a hand moves, is none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.spectrum import find_vibration
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint

DATA = moved_joint(duration_s=60.0)
N = len(DATA.t)


def white(seed: int) -> Float:
    return 0.02 * np.random.default_rng(seed).standard_normal(N)


def resonance(frequency_hz: float, bandwidth_hz: float, rms: float, seed: int) -> Float:
    """White noise through a damped oscillator, two poles."""
    step = DATA.step_s
    radius = np.exp(-np.pi * bandwidth_hz * step)
    poles = [1.0, -2.0 * radius * np.cos(2 * np.pi * frequency_hz * step), radius**2]
    ringing = lfilter([1.0], poles, np.random.default_rng(seed).standard_normal(N))
    return np.asarray(rms * ringing / ringing.std())


@pytest.mark.parametrize("frequency_hz", [5.0, 13.0, 30.0])
def test_a_line_is_found_with_its_size(frequency_hz: float) -> None:
    found = find_vibration(white(0) + 0.05 * np.sqrt(2) * np.sin(2 * np.pi * frequency_hz * DATA.t), DATA)
    assert found is not None
    assert found.frequency_hz == pytest.approx(frequency_hz, abs=0.5)
    assert found.low_hz < frequency_hz < found.high_hz
    assert found.rms_nm == pytest.approx(0.05, rel=0.1)


def test_a_broad_hump_at_13_hz_is_found() -> None:
    found = find_vibration(white(1) + resonance(13.0, 1.5, 0.03, 2), DATA)
    assert found is not None
    assert found.frequency_hz == pytest.approx(13.0, abs=1.0)
    assert 8.0 < found.low_hz < 12.5
    assert 13.5 < found.high_hz < 18.0
    assert found.rms_nm == pytest.approx(0.03, rel=0.25)


def test_the_stronger_of_two_is_told() -> None:
    found = find_vibration(white(2) + resonance(8.0, 0.5, 0.02, 3) + resonance(20.0, 0.5, 0.06, 4), DATA)
    assert found is not None
    assert found.frequency_hz == pytest.approx(20.0, abs=0.5)


@pytest.mark.parametrize("memory", [0.0, 0.9, 0.98, 0.998])
def test_noise_of_any_colour_is_no_vibration(memory: float) -> None:
    found = [find_vibration(np.asarray(lfilter([1.0], [1.0, -memory], white(seed))), DATA) for seed in range(40)]
    assert found == [None] * 40


def test_a_line_above_40_hz_is_not_looked_for() -> None:
    assert find_vibration(white(5) + 0.05 * np.sin(2 * np.pi * 60.0 * DATA.t), DATA) is None


def test_too_little_motion_shows_nothing() -> None:
    shaking = np.sin(2 * np.pi * 13.0 * DATA.t)
    still = replace(DATA, moving=DATA.t < 4.0)
    assert find_vibration(shaking, still) is None
    short = moved_joint(duration_s=1.0)
    assert find_vibration(shaking[: len(short.t)], short) is None


def tremor(rms: float) -> Float:
    """Torque that a hand at 8 to 12 Hz takes for the inertia of a joint."""
    shaken = resonance(10.0, 1.5, 1.0, 20)
    return np.asarray(rms * shaken)


def encoder_noise(rms: float) -> Float:
    """Inertia times the second difference of what an encoder misses."""
    noise = np.gradient(np.gradient(np.random.default_rng(23).standard_normal(N)))
    return np.asarray(rms * noise / noise.std())


def test_a_hand_that_trembles_moves_the_joint_and_is_no_vibration() -> None:
    motion = tremor(0.05)
    assert find_vibration(white(6) + motion, DATA) is not None
    assert find_vibration(white(6) + motion, DATA, motion) is None


@pytest.mark.parametrize("noise", [0.2, 1.0, 5.0])
def test_a_hand_that_trembles_is_known_beside_noise_of_the_encoder(noise: float) -> None:
    motion = tremor(0.05)
    assert find_vibration(white(6) + motion, DATA, motion + encoder_noise(noise)) is None


def test_a_line_beside_a_trembling_hand_is_found_with_its_size() -> None:
    line = 0.03 * np.sqrt(2) * np.sin(2 * np.pi * 17.0 * DATA.t)
    found = find_vibration(white(8) + tremor(0.05) + line, DATA, tremor(0.05) + encoder_noise(0.05))
    assert found is not None
    assert found.frequency_hz == pytest.approx(17.0, abs=0.5)
    assert found.rms_nm == pytest.approx(0.03, rel=0.1)


def test_a_line_beside_noise_of_the_encoder_is_found_as_if_there_were_none() -> None:
    torque = white(9) + 0.05 * np.sqrt(2) * np.sin(2 * np.pi * 26.0 * DATA.t)
    noise = encoder_noise(5.0)
    found = find_vibration(torque, DATA, noise)
    assert found == find_vibration(torque, DATA)
    assert found is not None
    assert find_vibration(torque - noise, DATA) is None


def test_an_encoder_that_shakes_more_than_what_the_torque_moves_hides_nothing() -> None:
    shaking = resonance(26.0, 2.0, 0.05, 21)
    found = find_vibration(white(10) + shaking, DATA, 5.0 * shaking + encoder_noise(0.5))
    assert found is not None
    assert found.rms_nm == pytest.approx(0.05, rel=0.25)


def test_no_more_than_all_of_the_motion_is_taken_off() -> None:
    shaking = resonance(13.0, 1.5, 0.05, 22)
    found = find_vibration(white(11) + shaking, DATA, 0.2 * shaking)
    assert found is not None
    assert found.rms_nm == pytest.approx(0.04, rel=0.25)
