"""Touches are found where they are, and nothing else is taken for one."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.find_contacts import contact_grid, find_contacts
from friction_audit.effects.contact_event import EFFECT as CANDIDATE
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import baseline, joint_data, two_sines

MOTION = two_sines()
PLAIN = baseline(MOTION).torque
NOISE = np.random.default_rng(1).normal(scale=0.02, size=len(MOTION.t))


def with_torque(torque: Float) -> JointData:
    return replace(MOTION, torque=PLAIN + NOISE + torque)


def push(start: float, length: float, size: float) -> Float:
    """Half a sine."""
    x = (MOTION.t - start) / length
    return np.where((x > 0) & (x < 1), size * np.sin(np.pi * x), 0.0)


def test_noise_is_no_contact() -> None:
    data = with_torque(np.zeros(len(MOTION.t)))
    assert find_contacts(data) == ()
    assert contact_grid(data) == ({},)
    assert not CANDIDATE.admissible(np.ones(1), {})


@pytest.mark.parametrize(("length", "size"), [(0.1, 0.3), (0.3, -0.1), (1.0, 0.1), (3.0, 0.05)])
def test_a_touch_is_found_where_it_is(length: float, size: float) -> None:
    (found,) = find_contacts(with_torque(push(20.0, length, size)))
    assert 18.9 < found.start_s < 20.0 + 0.5 * length < found.stop_s < 21.1 + length


def test_several_touches_are_one_effect_with_a_curve_each() -> None:
    torque = push(10.0, 0.2, 0.5) + push(31.0, 0.4, -0.3) + push(50.0, 0.2, 0.2)
    data = with_torque(torque)
    assert len(find_contacts(data)) == 3
    (shape,) = contact_grid(data)
    columns = CANDIDATE.regressor(data, baseline(data), shape)
    left = torque - columns @ np.linalg.lstsq(columns, torque)[0]
    assert columns.shape[1] == 15
    assert np.sum(left**2) < 0.05 * np.sum(torque**2)


def test_what_comes_with_every_stroke_is_no_contact() -> None:
    turn = np.flatnonzero(np.diff(np.sign(MOTION.dq)) != 0)
    every = np.sum([push(float(MOTION.t[k]), 0.1, 0.4) for k in turn], axis=0)
    assert find_contacts(with_torque(every)) == ()


@pytest.mark.parametrize("speed", [0.02, 0.1])
def test_friction_of_another_law_at_a_slow_reversal_is_no_contact(speed: float) -> None:
    smooth = np.tanh(MOTION.dq / speed) - np.sign(MOTION.dq)
    assert find_contacts(with_torque(0.3 * smooth)) == ()


def test_friction_that_has_changed_turns_with_the_direction_and_is_no_contact() -> None:
    late = np.abs(MOTION.t - MOTION.t[-1] + 5.0) < 2.5
    assert find_contacts(with_torque(0.15 * late)) != ()
    assert find_contacts(with_torque(0.15 * late * np.sign(MOTION.dq))) == ()


def test_a_joint_at_rest_has_none() -> None:
    assert find_contacts(replace(MOTION, moving=np.zeros(len(MOTION.t), bool))) == ()


def test_a_joint_that_clearly_moves_for_one_sample_has_none() -> None:
    sample = np.arange(len(MOTION.t))
    assert find_contacts(replace(MOTION, moving=(sample >= 560) & (sample < 570))) == ()


def turn(number: int) -> float:
    return float(MOTION.t[np.flatnonzero(np.diff(np.sign(MOTION.dq)) != 0)[number]])


@pytest.mark.parametrize("late", [-0.25, -0.15, -0.05])
def test_a_touch_that_turns_the_joint_is_one(late: float) -> None:
    (found,) = find_contacts(with_torque(push(turn(20) + late, 0.3, -0.4)))
    assert found.start_s < turn(20) + late + 0.15 < found.stop_s


def stop_and_go() -> JointData:
    """Half sines of 1 s, to and fro, rests of 0.5 s between them, in which friction holds whatever drives."""
    t = np.arange(0.0, 90.0, 0.005)
    phase, side = t % 1.5, np.where((t // 1.5) % 2 == 0, 1.0, -1.0)
    dq = np.where(phase < 1.0, side * np.sin(np.pi * phase), 0.0)
    ddq = np.where(phase < 1.0, side * np.pi * np.cos(np.pi * phase), 0.0)
    data = joint_data(np.cumsum(dq) * 0.005, dq, ddq)
    rng = np.random.default_rng(2)
    held = np.repeat(rng.uniform(-0.3, 0.3, 60), 300)
    friction = np.where(dq != 0.0, 0.3 * np.sign(dq) + 0.07 * dq, held)
    return replace(data, torque=0.3 * ddq + friction + rng.normal(scale=0.02, size=len(t)))


def test_what_friction_can_hold_at_rest_is_no_touch_and_more_is_one() -> None:
    data = stop_and_go()
    assert find_contacts(data) == ()
    late = (data.t > 31.2) & (data.t < 31.6)  # the joint stops at 31.0 s and goes on at 31.5 s
    (found,) = find_contacts(replace(data, torque=data.torque + 1.5 * late))
    assert found.start_s < 31.5 < found.stop_s


def test_a_gear_that_winds_up_behind_a_rest_before_friction_has_turned_is_no_touch() -> None:
    data, rest_s, start_s, creep_s, creep = stop_and_go(), 31.0, 31.5, 0.15, 5e-3  # rad/s: by 0.75 mrad
    way = float(np.sign(data.dq[np.searchsorted(data.t, start_s + 0.5)]))
    rests, winds = (data.t >= rest_s) & (data.t < start_s - creep_s), (data.t >= start_s - creep_s) & (data.t < start_s)
    dq = np.where(winds, way * creep, data.dq)
    noise = np.random.default_rng(5).normal(scale=0.02, size=len(dq))
    friction = np.interp(data.t, [start_s - creep_s, start_s], [-0.3 * way, 0.3 * way])
    torque = np.where(rests | winds, friction + noise, data.torque)
    q, moving = np.cumsum(dq) * 0.005, np.abs(dq) > 0.2 * creep
    wound = replace(data, q=q, dq=dq, torque=torque, moving=moving, dead_speed_rad_s=0.2 * creep)
    assert find_contacts(wound) == ()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_quiet_sensor_beside_an_encoder_s_noise_sees_no_touch_in_brisk_strokes(seed: int) -> None:
    encoder = np.random.default_rng(seed).normal(scale=2e-5, size=len(NOISE) + 2)
    ddq = MOTION.ddq + np.diff(encoder, n=2) / MOTION.step_s**2
    assert find_contacts(replace(MOTION, torque=PLAIN + 0.1 * NOISE, ddq=ddq)) == ()
