"""Energy cycles whose borders and energies are known by hand."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from friction_audit.joint_log import Float
from friction_audit.preprocessing import energy_cycles
from friction_audit.preprocessing.energy_cycles import GAP, KEPT, LONG, ONE_WAY, OPEN, SMALL
from friction_audit.preprocessing.segmentation import without_small
from friction_audit.preprocessing.settings import CycleSettings
from tests.synthetic_interaction import RATE_HZ, cycles_of, interaction, passed, strokes

COULOMB, VISCOUS, INERTIA = 0.3, 0.07, 0.5
BACK_AND_FORTH = ([0.8, -0.5, 0.6, -0.9], [1.2, 0.9, 1.0, 1.1])


def rubbed(lengths: list[float], durations: list[float], scale: float = 1.0) -> tuple[Float, Float, Float]:
    t, v, a = strokes(lengths, durations)
    v, a = scale * v, scale * a
    return t, v, COULOMB * np.sign(v) + VISCOUS * v + INERTIA * a


def test_each_stroke_is_a_cycle_and_its_energies_are_known_by_hand() -> None:
    t, v, torque = rubbed(*BACK_AND_FORTH)
    (cycles,) = cycles_of(interaction(t, v, torque))
    assert len(cycles.start) == 4
    lengths, durations = (np.array(x) for x in BACK_AND_FORTH)
    np.testing.assert_allclose(cycles.sums.path_rad, np.abs(lengths), rtol=1e-5)
    np.testing.assert_allclose(cycles.sums.displacement_rad, lengths, rtol=1e-5)
    square = lengths**2 / durations * 10 / 7  # integral of the squared minimum-jerk velocity
    np.testing.assert_allclose(cycles.sums.square_speed_rad2_s, square, rtol=1e-5)
    np.testing.assert_allclose(cycles.sums.work_j, COULOMB * np.abs(lengths) + VISCOUS * square, rtol=1e-4)
    assert np.all((cycles.reason == KEPT) & cycles.open)
    assert np.all(cycles.start[1:] == cycles.stop[:-1])


def test_a_cycle_of_more_than_five_minutes_does_not_count() -> None:
    lengths, durations = [0.8, -0.5, 0.6, -0.6], [1.2, 0.9, 1.0, 1.1]
    _, v, torque = rubbed(lengths, durations)
    rest = int(np.flatnonzero(np.abs(v) > 0.05)[-1]) + 100  # after the last stroke
    wait = int(301 * RATE_HZ)
    v, torque = (np.concatenate([x[:rest], np.zeros(wait), x[300:]]) for x in (v, torque))
    (cycles,) = cycles_of(interaction(np.arange(len(v)) / RATE_HZ, v, torque))
    assert cycles.reason.tolist() == [KEPT] * 4 + [LONG] + [KEPT] * 3
    np.testing.assert_allclose(cycles.sums.path_rad, np.abs(lengths * 2), rtol=1e-5)


def test_the_gravity_columns_are_the_work_of_a_pendulum() -> None:
    t, v, torque = rubbed([1.0, -1.0], [1.0, 1.0])
    (cycles,) = cycles_of(interaction(t, v, torque))
    np.testing.assert_allclose(cycles.sums.gravity_x_rad, [1 - np.cos(1.0), np.cos(1.0) - 1], atol=1e-5)
    np.testing.assert_allclose(cycles.sums.gravity_y_rad, [np.sin(1.0), -np.sin(1.0)], atol=1e-5)


def test_a_hole_in_the_log_is_left_out() -> None:
    t, v, torque = rubbed(*BACK_AND_FORTH)
    keep = (t < 0.8) | (t > 0.9)
    (cycles,) = cycles_of(interaction(t[keep], v[keep], torque[keep]))
    assert cycles.reason.tolist() == [GAP, KEPT, KEPT, KEPT]


def test_strokes_on_both_sides_of_a_reversal_that_a_hole_hides_do_not_count() -> None:
    t = np.arange(0.0, 3.0, 1.0 / RATE_HZ)
    t = t[(t < 1.2) | (t > 1.4)]
    v = np.cos(2.0 * np.pi * t)
    (cycles,) = cycles_of(interaction(t, v, COULOMB * np.sign(v)))
    assert cycles.reason.tolist() == [KEPT, GAP, GAP, KEPT, KEPT]


def test_a_joint_that_never_comes_back_has_no_closed_cycle() -> None:
    (cycles,) = cycles_of(interaction(*rubbed([0.8, 0.5], [1.0, 1.0])))
    assert cycles.reason.tolist() == [ONE_WAY, ONE_WAY]


def test_with_gravity_in_the_torque_only_closed_paths_count() -> None:
    t, v, torque = rubbed([0.8, -0.8, 0.6, -0.9], [1.0, 1.0, 1.0, 1.0])
    (cycles,) = cycles_of(interaction(t, v, torque, gravity="in-torque"))
    assert cycles.reason.tolist() == [KEPT, OPEN, OPEN]
    assert abs(cycles.sums.displacement_rad[0]) < 1e-4
    assert cycles.sums.path_rad[0] == pytest.approx(1.6, rel=1e-4)


def test_a_path_is_closed_only_if_every_joint_returns() -> None:
    t, v, torque = rubbed([0.8, -0.8], [1.0, 1.0])
    other = np.where(t > 1.4, 0.3 * np.sin(t - 1.4) ** 2, 0.0)
    log = interaction(t, np.stack([v, other], 1), np.stack([torque, other], 1), gravity="in-torque")
    assert cycles_of(log)[0].reason.tolist() == [OPEN, OPEN]


def test_slow_logs_need_lower_thresholds_and_auto_finds_them_above_the_noise() -> None:
    t, v, torque = rubbed([0.1, -0.1, 0.08, -0.1], [2.0, 2.5, 2.0, 2.2])
    slow = interaction(t, v, torque)
    lower = CycleSettings(initiation_rad_s=0.05, termination_rad_s=0.01)
    assert [len(cycles_of(slow, one)[0].start) for one in (CycleSettings(), lower)] == [0, 4]
    (auto,) = cycles_of(slow, CycleSettings(thresholds="auto"))
    assert len(auto.start) == 4
    assert 0.005 < auto.initiation < 0.06
    noise = 0.003 * np.random.default_rng(0).normal(size=len(v))
    noisy = interaction(t, v + noise, torque, q=np.cumsum(v) / 1000)
    assert len(cycles_of(noisy, CycleSettings(thresholds="auto"))[0].start) == 4


def test_the_hand_defines_cycles_for_all_joints_at_once() -> None:
    t, v, torque = rubbed([0.8, -0.8, 0.8], [1.0, 1.0, 1.0])
    lazy = np.where(t < 2.8, v, 0.01 * v)
    log = interaction(t, np.stack([v, lazy], 1), np.stack([torque, torque], 1))
    by_hand = CycleSettings(cycles_from="hand")
    joints = passed(log, by_hand, hand_speed=np.abs(v) * 0.5)
    first, second = without_small([joint.search.cycles() for joint in joints], by_hand)
    assert first.start.tolist() == second.start.tolist()
    assert first.reason.tolist() == second.reason.tolist() == [KEPT, KEPT, SMALL]


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(0.3, 1.0), min_size=2, max_size=6), st.floats(0.0, 50.0))
def test_a_shift_in_time_changes_nothing_and_joints_are_independent(lengths: list[float], shift_s: float) -> None:
    signed = [x if k % 2 == 0 else -x for k, x in enumerate(lengths)]
    t, v, torque = rubbed(signed, [1.0] * len(signed))
    (once,) = cycles_of(interaction(t, v, torque))
    (later,) = cycles_of(interaction(t + shift_s, v, torque))
    _, second = cycles_of(interaction(t, np.stack([0 * v, v], 1), np.stack([v, torque], 1)))
    np.testing.assert_allclose(later.sums.work_j, once.sums.work_j, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(second.sums.work_j, once.sums.work_j)


def test_two_humps_without_rest_are_one_stroke_with_rest_or_without_a_sign_two() -> None:
    t = np.arange(0, 2.0, 0.001)
    dip = np.pad(0.5 * np.abs(np.sin(np.pi * t)) + 0.01, 100)
    rest = np.where(np.abs(np.arange(len(dip)) - 1100) < 50, 0.0, dip)
    assert len(energy_cycles.find_borders(dip, 0.2, 0.05, merge=True)) == 2
    assert len(energy_cycles.find_borders(rest, 0.2, 0.05, merge=True)) == 3
    assert energy_cycles.find_borders(dip, 0.2, 0.05, merge=False).tolist()[1] == 1100


def test_velocity_noise_at_rest_adds_no_path() -> None:
    t = np.arange(20_000) / 1000
    noise, filtered = np.random.default_rng(1).normal(size=(2, len(t))) * [[0.003], [1e-4]]
    sums = energy_cycles.add_up(t, np.zeros_like(t), noise, filtered, noise, None, np.array([[0, 19_999]]))
    assert sums["rectified_path_rad"].item() > 0.04  # 0.0024 rad per second of dwell
    assert sums["path_rad"].item() == 0.0
