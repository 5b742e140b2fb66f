"""An effect is as large in one half of the motion as in the other, or it is another effect's shadow."""

from collections.abc import Callable

import numpy as np
import pytest

from friction_audit.diagnosis.constancy import Half, _difference, find_inconstant
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint


def ground_of(missing: Callable[[JointData], Float]) -> Ground:
    return make_ground(moved_joint(missing, noise_nm=0.01), None, 0)


def square(data: JointData) -> Float:
    return 0.1 * data.dq * np.abs(data.dq)


def place(data: JointData) -> Float:
    return 0.1 * np.exp(-(((data.q - 0.6) / 0.2) ** 2))


def told(missing: Callable[[JointData], Float], *named: Callable[[JointData], Float]) -> tuple[str, ...]:
    ground = ground_of(missing)
    return find_inconstant(ground, [(one.__name__, ground.rows.of(one(ground.data)[:, None])) for one in named])


def test_what_is_one_mechanism_is_not_told() -> None:
    assert told(square, square) == ()
    assert told(lambda data: square(data) + place(data), square, place) == ()


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_is_larger_while_the_joint_speeds_up_or_slows_down_is_told(sign: float) -> None:
    (phrase,) = told(lambda data: square(data) * (1.0 + 0.6 * sign * np.sign(data.ddq * data.dq)), square)
    more, less = ("speeds up", "slows down")[:: int(sign)]
    assert phrase.startswith("square is larger while")
    assert phrase.index(more) < phrase.index(less)


def test_what_changes_with_time_or_place_is_told_too() -> None:
    (early,) = told(lambda data: square(data) * np.where(data.t < 30.0, 1.6, 0.4), square)
    assert "square is larger early than late in the log" in early
    (high,) = told(lambda data: square(data) * np.where(data.q > 0.0, 1.6, 0.4), square)
    assert "square is larger high in the range than low in it" in high


def test_a_difference_of_a_third_may_be_what_a_formula_does_not_get_right() -> None:
    assert told(lambda data: square(data) * np.where(data.t < 30.0, 1.15, 0.85), square) == ()


def test_the_difference_is_that_of_the_two_factors_over_their_mean() -> None:
    rng = np.random.default_rng(0)
    column, noise = rng.standard_normal((2, 20000))
    half = Half(inside=np.arange(20000) % 2 == 0, here="", there="")
    y = np.where(half.inside, 1.4, 0.6) * column + 0.1 * noise
    share, z = _difference(y, column[:, None], 0, half, 4.0, np.zeros(20000))
    assert share == pytest.approx(0.8, abs=0.01)
    # An error of 2 sigma / sqrt(n), twice that for a memory of four samples.
    assert z == pytest.approx(0.8 / (2.0 * 0.1 * 2.0 / np.sqrt(20000)), rel=0.05)


def of_motion_and_noise(share: float) -> tuple[Float, Float, Float, Half]:
    """A response of one mechanism, a column with noise of this size beside it in one half, that noise, and the half."""
    rng = np.random.default_rng(1)
    moved, wrong, again, noise = rng.standard_normal((4, 20000))
    half = Half(inside=np.arange(20000) % 2 == 0, here="", there="")
    size = np.where(half.inside, share, 0.0)
    return moved + 0.1 * noise, moved + size * wrong, size * again, half


def test_a_column_that_is_partly_noise_has_a_smaller_factor_and_is_no_other_mechanism() -> None:
    y, column, noise, half = of_motion_and_noise(0.8)
    told_by_the_column, z = _difference(y, column[:, None], 0, half, 1.0, np.zeros(20000))
    assert told_by_the_column == pytest.approx(2.0 * (1.0 / 1.64 - 1.0) / (1.0 / 1.64 + 1.0), abs=0.15)
    assert z < -10.0
    assert _difference(y, column[:, None], 0, half, 1.0, noise)[0] == pytest.approx(0.0, abs=0.05)


def test_a_half_that_is_mostly_noise_says_nothing() -> None:
    y, column, noise, half = of_motion_and_noise(1.2)
    assert _difference(y, column[:, None], 0, half, 1.0, noise) == (0.0, 0.0)


def test_a_half_that_hardly_holds_the_effect_says_nothing() -> None:
    column = np.ones(1000)
    column[500:] = 0.01
    half = Half(inside=np.arange(1000) < 500, here="", there="")
    assert _difference(column + 1.0, np.column_stack([column]), 0, half, 1.0, np.zeros(1000)) == (0.0, 0.0)


def test_a_difference_that_the_declared_model_holds_says_nothing() -> None:
    """An offset by direction is Coulomb friction."""
    sign = np.resize([1.0, -1.0], 1000)
    half = Half(inside=sign > 0.0, here="", there="")
    assert _difference(np.ones(1000), np.column_stack([sign, np.ones(1000)]), 1, half, 1.0, np.zeros(1000)) == (
        0.0,
        0.0,
    )
