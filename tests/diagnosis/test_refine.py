"""A shape between two values of the grid is found, within bounds and where the factors are possible."""

from collections.abc import Callable

import numpy as np
import pytest

from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.refine import refine
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.toy_candidates import BUMP, SQUARE, altered

NUMBERS = ("place_rad", "width_rad")
WIDE = altered(
    BUMP,
    grid=tuple({"place_rad": place, "width_rad": width} for place in (0.0, 0.3, 0.6) for width in (0.1, 0.3, 0.9)),
)


def bump(place: float, width: float, size: float = 0.1) -> Callable[[JointData], Float]:
    return lambda data: size * np.exp(-(((data.q - place) / width) ** 2))


def ground_of(missing: Callable[[JointData], Float], noise_nm: float = 0.0) -> Ground:
    return make_ground(moved_joint(missing, noise_nm=noise_nm, duration_s=30.0), None, 0)


def refined(ground: Ground, candidate: Effect, shape: Nonlinear) -> Nonlinear:
    return refine(candidate, shape, candidate.grid(ground.data), ground, ground.baseline(), ground.base)


@pytest.mark.parametrize("place", [0.13, 0.22, 0.41])
def test_one_number_is_found_between_its_neighbours(place: float) -> None:
    found = refined(ground_of(bump(place, 0.2)), BUMP, {"place_rad": 0.3, "width_rad": 0.2})
    assert found["place_rad"] == pytest.approx(place, abs=0.003)
    assert found["width_rad"] == 0.2


def test_a_number_between_the_values_of_the_grid_may_be_refined_again() -> None:
    found = refined(ground_of(bump(0.41, 0.2)), BUMP, {"place_rad": 0.22, "width_rad": 0.2})
    assert found["place_rad"] == pytest.approx(0.41, abs=0.003)


@pytest.mark.parametrize("found_before", [0.2999, 0.3001])
@pytest.mark.parametrize("place", [0.13, 0.41])
def test_a_search_that_ended_beside_a_value_of_the_grid_goes_on_beyond_it(found_before: float, place: float) -> None:
    shape = {"place_rad": found_before, "width_rad": 0.2}
    wider = altered(BUMP, shapes=(*BUMP.grid(ground_of(bump(0.0, 0.2)).data), shape))
    assert refined(ground_of(bump(place, 0.2)), wider, shape)["place_rad"] == pytest.approx(place, abs=0.003)


def test_two_numbers_are_found_together() -> None:
    found = refined(ground_of(bump(0.36, 0.24)), WIDE, {"place_rad": 0.3, "width_rad": 0.3})
    assert found == pytest.approx({"place_rad": 0.36, "width_rad": 0.24}, rel=0.05)


def test_noise_moves_it_little() -> None:
    found = refined(ground_of(bump(0.2, 0.2), noise_nm=0.02), BUMP, {"place_rad": 0.3, "width_rad": 0.2})
    assert found["place_rad"] == pytest.approx(0.2, abs=0.02)


def test_the_search_stays_between_the_neighbours() -> None:
    found = refined(ground_of(bump(-0.5, 0.2)), BUMP, {"place_rad": 0.3, "width_rad": 0.2})
    assert 0.0 <= found["place_rad"] <= 0.6


def test_beyond_the_last_value_it_goes_on_by_a_step_and_a_half() -> None:
    found = refined(ground_of(bump(0.8, 0.2)), BUMP, {"place_rad": 0.6, "width_rad": 0.2})
    assert found["place_rad"] == pytest.approx(0.8, abs=0.01)


def test_no_number_leaves_the_bounds_of_its_parameter() -> None:
    place, width = (Parameter(name=name, unit="rad", meaning="", lower=0.0, upper=0.7) for name in NUMBERS)
    bounded = altered(BUMP, nonlinear=(place, width))
    found = refined(ground_of(bump(0.8, 0.2)), bounded, {"place_rad": 0.6, "width_rad": 0.2})
    assert 0.69 < found["place_rad"] <= 0.7


def test_a_choice_is_not_refined() -> None:
    place, width = (Parameter(name=name, unit="1", meaning="", whole=name == "place_rad") for name in NUMBERS)
    chosen = altered(WIDE, nonlinear=(place, width))
    found = refined(ground_of(bump(0.36, 0.24)), chosen, {"place_rad": 0.3, "width_rad": 0.3})
    assert found["place_rad"] == 0.3
    assert found["width_rad"] != 0.3


def test_zero_at_the_edge_of_the_grid_is_kept_where_it_is_best() -> None:
    grid = tuple({"width_rad": width, "place_rad": 0.3} for width in (0.2, 0.6))
    shape = {"width_rad": 0.2, "place_rad": 0.3}
    assert refined(ground_of(bump(0.3, 0.2)), altered(BUMP, grid=grid), shape) is shape


def test_no_number_no_search() -> None:
    ground = ground_of(bump(0.2, 0.2))
    assert refined(ground, SQUARE, {}) == {}
    still = {"place_rad": 0.0, "width_rad": 0.2}
    assert refined(ground, altered(BUMP, grid=(still,)), still) is still


def test_where_no_factors_are_possible_the_shape_of_the_grid_stays() -> None:
    shape = {"place_rad": 0.3, "width_rad": 0.2}
    assert refined(ground_of(bump(0.2, 0.2, size=-0.1)), BUMP, shape) is shape
