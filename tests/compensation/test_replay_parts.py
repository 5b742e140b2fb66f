"""Parts of a replay by hand: steps of friction, convergence, cycles of the hand, sums, limits."""

import numpy as np
import pytest

from friction_audit.compensation.closed_loop import CYCLE
from friction_audit.compensation.controller import hand_cuts
from friction_audit.compensation.result import ReplayHistory, dissipation_removed, find_step, first_right
from friction_audit.joint_log import Float


def history(friction: list[float], left: list[float]) -> ReplayHistory:
    made = np.zeros(len(friction), CYCLE).view(np.recarray)
    made.friction_j, made.net_energy_j = friction, left
    return made


def test_what_is_given_out_counts_as_left_over() -> None:
    found = history([1.0, 1.0, 2.0], [1.0, -0.5, 0.5])
    assert dissipation_removed(found) == pytest.approx(0.5)
    assert dissipation_removed(history([1.0], [-0.5])) == pytest.approx(0.5)
    assert np.isnan(dissipation_removed(found, 3))
    assert np.isnan(dissipation_removed(history([-1.0], [0.0])))


def test_right_means_three_in_a_row() -> None:
    left = [1.0, 0.05, 0.5, 0.1, -0.1, 0.0, 0.9]
    assert first_right(history([1.0] * 7, left)) == 3
    assert first_right(history([1.0] * 7, left), 4) is None
    assert first_right(history([1.0, 1.0], [0.0, 0.0])) is None


def cycles(after: float, at: int, count: int = 24) -> tuple[Float, Float, Float]:
    """Return path, squared speed and friction of strokes at changing speed, of which friction changes at one."""
    path = 0.5 + 0.2 * np.sin(np.arange(count))
    speed = 0.8 + 0.3 * np.cos(2.0 * np.arange(count))
    factor = np.where(np.arange(count) < at, 1.0, after)
    return path, path * speed, factor * path * (0.3 + 0.1 * speed)


def test_neither_speed_nor_noise_nor_warming_up_is_a_step() -> None:
    rng = np.random.default_rng(2)
    path, square, friction = cycles(1.0, 10)
    assert find_step(path, square, friction) is None
    for _ in range(20):
        assert find_step(path, square, friction * (1.0 + 0.2 * rng.standard_normal(len(path)))) is None
    assert find_step(path, square, friction * np.linspace(2.0, 1.0, len(path))) is None
    assert find_step(path[:5], square[:5], friction[:5]) is None
    assert find_step(0.0 * path, square, friction) is None


def test_the_hand_ends_cycles_when_all_joints_have_moved() -> None:
    t: Float = np.arange(4001, dtype=np.float64) * 1e-3
    speed = np.abs(np.sin(np.pi * t))
    dq = np.stack([np.sin(np.pi * t), np.where(t < 1.0, 0.0, np.sin(np.pi * t))], axis=1)

    def cuts(minimum_path_rad: float) -> list[float]:
        found = hand_cuts(t, speed, dq, (0.1, 0.025), 0.01, minimum_path_rad)
        return [float(t[i]) for i in np.flatnonzero(found)]

    # The second joint stands still in the first second: its cycle is the first two.
    np.testing.assert_allclose(cuts(0.1), [2.0, 3.0, 4.0], atol=0.02)
    np.testing.assert_allclose(cuts(0.0), [1.0, 2.0, 3.0, 4.0], atol=0.02)
    assert cuts(10.0) == []
