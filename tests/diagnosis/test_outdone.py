"""Names beside which a curve explains more than they do are not what is missing."""

from collections.abc import Callable

import numpy as np
import pytest

from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.outdone import _speaks, find_outdone, what_speaks
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint


def thick(data: JointData) -> Float:
    return np.asarray(np.sign(data.dq) * np.abs(data.ddq))


def square(data: JointData) -> Float:
    return np.asarray(data.dq * np.abs(data.dq))


def told(
    missing: Callable[[JointData], Float], *named: Callable[[JointData], Float], along: tuple[str, ...] = ()
) -> str:
    ground = make_ground(moved_joint(missing, noise_nm=0.02, duration_s=40.0), None, 0)
    return find_outdone(ground, [ground.rows.of(one(ground.data)[:, None]) for one in named], len(named), along)


def speeding_up(data: JointData) -> Float:
    """Friction that is more at one acceleration than at another, a line."""
    return np.asarray(0.01 * np.sign(data.dq) * data.ddq)


def on_one_side(data: JointData) -> Float:
    """Friction that is more at one place: where a joint that swings to and fro is accelerated."""
    return np.asarray(0.01 * np.sign(data.dq) * data.q)


def test_what_names_its_mechanism_is_not_outdone() -> None:
    assert told(lambda data: 0.02 * thick(data), thick) == ""
    assert told(lambda data: 0.03 * square(data), square) == ""


def test_what_takes_a_part_is_outdone_by_a_curve_over_the_right_quantity() -> None:
    def half(data: JointData) -> Float:
        return np.asarray(thick(data) * (data.q > 0.3))

    assert told(lambda data: 0.02 * thick(data), half).startswith("a curve over acceleration explains more")


def test_what_runs_alike_and_tells_nothing_beside_a_curve_over_the_right_quantity_is_not_it() -> None:
    instead = "a curve over acceleration explains all that what was named does, and more"
    assert told(speeding_up, on_one_side, along=("position",)) == instead


def test_a_curve_over_what_a_name_is_a_function_of_only_mends_its_formula() -> None:
    assert told(speeding_up, on_one_side, along=("position", "acceleration")) == ""


def test_what_is_there_tells_something_beside_any_curve_over_what_runs_alike() -> None:
    assert told(on_one_side, on_one_side, along=("position",)) == ""
    assert told(lambda data: on_one_side(data) - 0.5 * speeding_up(data), on_one_side, along=("position",)) == ""


def test_what_is_left_beside_a_larger_effect_does_not_outdo_it() -> None:
    assert told(lambda data: 0.01 * thick(data) + 0.2 * square(data), square) == ""


def test_without_names_nothing_is_outdone() -> None:
    assert told(lambda data: 0.02 * thick(data)) == ""


@pytest.mark.parametrize(
    ("gain", "numbers", "known"), [(5.0, 12, 0.0), (12.0, 12, 0.0), (12 * np.e, 12, 12 * (np.e - 2))]
)
def test_what_speaks_by_hand(gain: float, numbers: int, known: float) -> None:
    assert _speaks(gain, numbers) == pytest.approx(known)


def test_more_speaks_for_what_is_there_than_for_what_runs_alike() -> None:
    ground = make_ground(moved_joint(speeding_up, noise_nm=0.02, duration_s=40.0), None, 0)
    truth, relative = (
        what_speaks(ground, [ground.rows.of(one(ground.data)[:, None])], 1, 500.0) for one in (speeding_up, on_one_side)
    )
    assert truth > relative > 0.0
    assert what_speaks(ground, [], 0, 500.0) == 0.0
