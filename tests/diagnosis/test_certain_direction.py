"""Reversals in which a joint does not rest keep their direction; a rest of milliseconds takes it from all of them."""

import numpy as np
import pytest

from friction_audit.diagnosis.prepare import certain_direction
from friction_audit.joint_log import Float

STEP_S = 0.0025
DEAD = 0.003
ACCELERATION = 2.0
EVERY_S = 0.5


def velocity(dwell_s: float, jerk: float = 0.0) -> Float:
    """Strokes at constant acceleration, or growing, a rest of so long after each, through a filter of 12.5 ms."""
    t = np.arange(0.0, 10.0, STEP_S / 10)
    since = (t + 0.0003) % EVERY_S - EVERY_S / 2
    beyond = np.sign(since) * np.maximum(np.abs(since) - dwell_s / 2, 0.0)
    sharp = (ACCELERATION * beyond + jerk * beyond**2) * (-1.0) ** np.floor((t + 0.0003) / EVERY_S)
    window = np.hanning(52)[1:-1]
    smooth = np.convolve(sharp, window / window.sum(), mode="same")
    return np.asarray(smooth[::10])


def reversals(dq: Float) -> list[int]:
    return [k for k in np.flatnonzero(dq[1:] * dq[:-1] < 0).tolist() if abs(dq[k]) < ACCELERATION * EVERY_S / 8]


@pytest.mark.parametrize("jerk", [0.0, 5.0])
def test_a_reversal_without_a_rest_is_certain(jerk: float) -> None:
    dq = velocity(0.0, jerk)
    moving = certain_direction(dq, DEAD, STEP_S)
    inner = [k for k in reversals(dq) if 20 < k < len(dq) - 20]
    assert len(inner) > 15
    assert all(moving[k - 1 : k + 3].all() for k in inner)


@pytest.mark.parametrize("dwell_s", [0.002, 0.004, 0.008])
def test_a_short_rest_takes_the_certainty(dwell_s: float) -> None:
    dq = velocity(dwell_s)
    moving = certain_direction(dq, DEAD, STEP_S)
    assert not any(moving[k] and moving[k + 1] for k in reversals(dq))


def test_one_long_rest_among_sharp_reversals_is_left_out_alone() -> None:
    dq = velocity(0.0)
    rested = velocity(0.006)
    middle = slice(len(dq) // 2 + 50, len(dq) // 2 + 150)
    dq[middle] = rested[middle]
    moving = certain_direction(dq, DEAD, STEP_S)
    (inside,) = [k for k in reversals(dq) if middle.start < k < middle.stop]
    assert not moving[inside]
    assert all(moving[k] for k in reversals(dq) if k != inside and 20 < k < len(dq) - 20)


def test_a_turn_back_right_after_a_reversal_leaves_doubt() -> None:
    strokes = np.repeat([1.0, -1.0, 1.0], [60, 6, 60]) * 0.1
    moving = certain_direction(strokes, DEAD, STEP_S)
    assert not moving[[59, 60, 65, 66]].any()
    assert moving[:59].all()


def test_below_the_dead_speed_nothing_is_certain() -> None:
    assert not certain_direction(np.full(50, 0.5 * DEAD), DEAD, STEP_S).any()
    assert certain_direction(np.full(50, 2.0 * DEAD), DEAD, STEP_S).all()
