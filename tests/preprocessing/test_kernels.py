from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from friction_audit.preprocessing import kernels

NOTHING = np.empty(0)


def test_a_full_sine_has_borders_where_the_velocity_crosses_zero() -> None:
    t = np.arange(0, 4.0, 0.001)
    v = np.sin(np.pi * t + 1e-9)
    borders = kernels.find_borders(v, 0.2, 0.05, True)
    assert borders.tolist() == [0, 1000, 2000, 3000, 3999]


def test_a_log_that_begins_in_motion_begins_at_the_first_rest() -> None:
    t = np.arange(0, 4.0, 0.001)
    borders = kernels.find_borders(np.cos(np.pi * t), 0.2, 0.05, True)
    np.testing.assert_allclose(t[borders], [0.5, 1.5, 2.5, 3.5], atol=0.0011)


def test_two_humps_without_rest_are_one_stroke_and_with_rest_are_two() -> None:
    t = np.arange(0, 2.0, 0.001)
    dip = 0.5 * np.abs(np.sin(np.pi * t)) + 0.01
    rest = np.where(np.abs(t - 1.0) < 0.05, 0.0, dip)
    start = np.zeros(100)
    one = kernels.find_borders(np.concatenate([start, dip, start]), 0.2, 0.05, True)
    two = kernels.find_borders(np.concatenate([start, rest, start]), 0.2, 0.05, True)
    assert len(one) == 2
    assert len(two) == 3


def test_a_speed_that_dips_ends_a_cycle_because_it_has_no_sign() -> None:
    t = np.arange(0, 2.0, 0.001)
    speed = 0.5 * np.abs(np.sin(np.pi * t)) + 0.01
    borders = kernels.find_borders(np.concatenate([np.zeros(100), speed, np.zeros(100)]), 0.2, 0.05, False)
    assert borders.tolist()[1] == 1100


def test_nothing_that_moves_and_nothing_that_stops_gives_no_cycle() -> None:
    assert len(kernels.find_borders(np.zeros(100), 0.2, 0.05, True)) == 0
    assert len(kernels.find_borders(np.ones(100), 0.2, 0.05, True)) == 0


@given(arrays(np.float64, st.integers(1, 200), elements=st.floats(-1, 1)))
def test_borders_are_ordered_and_a_cycle_moves(velocity: np.ndarray) -> None:
    borders = kernels.find_borders(velocity, 0.2, 0.05, True)
    assert np.all(np.diff(borders) > 0)
    assert all(np.abs(velocity[a : b + 1]).max() > 0.05 for a, b in pairwise(borders))


def test_constant_torque_and_velocity_add_up_by_hand() -> None:
    t = np.array([0.0, 0.1, 0.3, 0.6, 1.0])  # uneven stamps
    v, torque, u = np.full(5, 2.0), np.full(5, 3.0), np.full(5, -1.0)
    edges, peak, longest = kernels.cut_evenly(t, v, np.array([0, 4]), 1)
    assert edges.tolist() == [[0, 4]]
    np.testing.assert_allclose([peak[0], longest[0]], [2.0, 0.4])
    work, compensation, printed, path, rectified, square, kinetic = kernels.add_up(t, 2 * t, v, v, torque, u, edges)[
        0, 0
    ]
    np.testing.assert_allclose([work, compensation, printed, path, rectified, square, kinetic], [6, -2, 4, 2, 2, 4, 0])


@given(st.integers(0, 10_000), st.integers(1, 8))
def test_parts_add_up_to_the_whole_and_cut_the_path_evenly(seed: int, parts: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5e-3, 1.5e-3, 400))
    v = np.sin(7 * t) + 0.01 * rng.normal(size=400)
    torque = rng.normal(size=400)
    borders = np.array([0, 150, 399])
    q = -np.cos(7 * t) / 7
    edges, _, _ = kernels.cut_evenly(t, v, borders, parts)
    whole = kernels.add_up(t, q, v, v, torque, NOTHING, np.array([[0, 150], [150, 399]]))
    cut = kernels.add_up(t, q, v, v, torque, NOTHING, edges)
    np.testing.assert_allclose(cut.sum(axis=1), whole.sum(axis=1), atol=1e-12)
    assert np.all(np.diff(edges, axis=1) >= 0)
    path = cut[:, :, kernels.PATH]
    np.testing.assert_allclose(path, path.mean(axis=1, keepdims=True) * np.ones(parts), atol=3e-3)


def test_velocity_noise_at_rest_adds_no_path() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(20_000) / 1000
    noise = 0.003 * rng.normal(size=len(t))
    filtered = 1e-4 * rng.normal(size=len(t))
    sums = kernels.add_up(t, np.zeros_like(t), noise, filtered, noise, NOTHING, np.array([[0, 19_999]]))
    assert sums[0, 0, kernels.RECTIFIED] > 0.04  # 0.0024 rad per second of dwell
    assert sums[0, 0, kernels.PATH] == 0.0
