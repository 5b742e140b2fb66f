"""Aged contacts by hand: the longer the rest the higher, gone after a short path, nothing without a rest."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.terms.stiction import TERM, since_onset
from friction_audit.joint_log import Float

STEP_S = 0.01


def moving(dq: Float) -> Motion:
    t: Float = np.arange(len(dq), dtype=np.float64) * STEP_S
    return Motion(t=t, q=np.cumsum(dq) * STEP_S, dq=dq, ddq=np.zeros(len(dq)))


def test_rest_and_path_by_hand() -> None:
    way = np.array([0.0, -1, 0, 0, 1, 1, 0, 1, 1])
    q = np.array([0.0, 0, 0, 0, 1, 3, 3, 2, 0])
    moves = np.array([False, False, False, False, True, True, False, True, True])
    rest, slid = since_onset(q, way, moves, STEP_S)
    assert_allclose(rest, [0, 0, 0, 0, 0.03, 0.03, 0, 0.03, 0.03])  # a stop of one sample is no rest
    assert_allclose(slid, [0, 0, 0, 0, 1, 3, 0, 4, 6])


def test_the_last_samples_of_a_rest_that_have_the_direction_of_the_onset_bear_its_excess() -> None:
    still, way = np.array([0.0, 0, 0, 0, 0, 0.2]), np.array([0.0, -1, 1, -1, -1, -1])
    rest, slid = since_onset(-np.cumsum(still), way, still > 0, STEP_S)
    assert_allclose(rest, [0, 0, 0, 0.04, 0.04, 0.04])
    assert_allclose(slid, [0, 0, 0, 0, 0, 0.2])
    dq = np.concatenate([np.zeros(90), np.full(10, -1e-4), np.full(50, -0.2)])
    column = TERM.regressor(moving(dq), (0.5, 0.02))[:, 0]
    assert_allclose(column[90:100], -(1 - np.exp(-0.99 / 0.5)))
    assert_array_equal(column[:90], 0.0)


def test_a_longer_rest_gives_more_and_the_path_takes_it_away() -> None:
    dq = np.concatenate([np.zeros(50), np.full(100, 0.2), np.zeros(200), np.full(100, -0.2)])
    column = TERM.regressor(moving(dq), (0.5, 0.02))[:, 0]
    assert_allclose(column[50], (1 - np.exp(-0.49 / 0.5)) * np.exp(-0.002 / 0.02))
    assert_allclose(column[60], column[50] * np.exp(-0.02 / 0.02))
    assert_allclose(column[350], -(1 - np.exp(-2.0 / 0.5)) * np.exp(-0.002 / 0.02))
    assert_array_equal(column[dq == 0.0], 0.0)


def test_without_a_rest_or_without_strength_there_is_none() -> None:
    wave = moving(np.sin(np.arange(2000) * 0.05 + 0.3))
    assert_array_equal(TERM.regressor(wave, (0.5, 0.02))[:2000], 0.0)
    assert_array_equal(TERM.torque((0.0, 0.5, 0.02), wave), 0.0)
