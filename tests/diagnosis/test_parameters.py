"""Intervals of factors and shapes of a grown model: exact without noise, and they cover."""

from functools import cache

import numpy as np
import pytest

from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.parameters import Parameters, parameters_of
from friction_audit.diagnosis.refine import refine
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.position_dependent_friction import EFFECT as PLACE_FRICTION
from friction_audit.joint_log import Float
from tests.diagnosis.found_effect import found_effect
from tests.diagnosis.moved_joint import TRUTH, moved_joint
from tests.diagnosis.toy_candidates import BUMP, WAVE, altered

PLACE, SIZE = 0.2, 0.1


def bump(data: JointData) -> Float:
    return SIZE * np.exp(-(((data.q - PLACE) / 0.2) ** 2))


@cache
def fitted(seed: int, noise_nm: float) -> Parameters:
    ground = make_ground(moved_joint(bump, noise_nm=noise_nm, duration_s=20.0, seed=seed), None, 0)
    start = {"place_rad": 0.3, "width_rad": 0.2}
    shape = refine(BUMP, start, BUMP.grid(ground.data), ground, ground.baseline(), ground.base)
    return parameters_of(ground, [found_effect(ground, BUMP, shape)], ground.baseline())


def test_numbers_are_exact_without_noise() -> None:
    numbers = fitted(0, 0.0)
    (effect,) = numbers.effects
    assert list(effect) == ["factor_1_nm", "place_rad", "width_rad"]
    assert effect["factor_1_nm"].value == pytest.approx(SIZE, rel=1e-3)
    assert effect["place_rad"].value == pytest.approx(PLACE, abs=1e-3)
    assert {name: one.value for name, one in numbers.declared.items()} == pytest.approx(TRUTH, rel=1e-3)


def test_intervals_cover_at_their_rate() -> None:
    fits = [fitted(seed, 0.03) for seed in range(40)]
    truth = {"factor_1_nm": SIZE, "place_rad": PLACE}
    for name, true in truth.items():
        ones = [fit.effects[0][name] for fit in fits]
        # 95 % of 40 are 38; fewer than 34 come less than once in a hundred times.
        assert sum(one.low <= true <= one.high for one in ones) >= 34, name
        assert np.mean([one.high - one.low for one in ones]) < 0.5 * true, name
    for name, true in TRUTH.items():
        assert sum(fit.declared[name].low <= true <= fit.declared[name].high for fit in fits) >= 34, name


def test_several_effects_keep_their_own_numbers() -> None:
    def missing(data: JointData) -> Float:
        return bump(data) + 0.05 * np.sin(0.5 * data.t) - 0.02 * np.cos(0.5 * data.t)

    ground = make_ground(moved_joint(missing, duration_s=30.0), None, 0)
    both = [
        found_effect(ground, WAVE, {"rate": 0.5}),
        found_effect(ground, BUMP, {"place_rad": PLACE, "width_rad": 0.2}),
    ]
    wave, hump = parameters_of(ground, both, ground.baseline()).effects
    assert (wave["factor_1_nm"].value, wave["factor_2_nm"].value) == pytest.approx((0.05, -0.02), rel=1e-6)
    assert hump["factor_1_nm"].value == pytest.approx(SIZE, rel=1e-6)


def test_what_a_shape_assumes_widens_the_interval_on_its_side() -> None:
    ground = make_ground(moved_joint(bump, noise_nm=0.02, duration_s=20.0), None, 0)
    shape = {"place_rad": PLACE, "width_rad": 0.2}
    loose = altered(BUMP, factor_ranges=lambda _shape: {"factor_1_nm": (1.0, 4.0)})
    (told,), (wider,) = (
        parameters_of(ground, [found_effect(ground, candidate, shape)], ground.baseline()).effects
        for candidate in (BUMP, loose)
    )
    own, loosened = told["factor_1_nm"], wider["factor_1_nm"]
    assert (loosened.value, loosened.low, loosened.high) == pytest.approx((own.value, own.low, 4.0 * own.high))
    assert wider["place_rad"].value == pytest.approx(told["place_rad"].value)


def test_nothing_found_leaves_the_declared_model() -> None:
    ground = make_ground(moved_joint(), None, 0)
    numbers = parameters_of(ground, [], ground.baseline())
    assert numbers.effects == ()
    assert {name: one.value for name, one in numbers.declared.items()} == pytest.approx(TRUTH)


def test_a_number_that_the_log_does_not_tell_has_no_bounds_and_spoils_no_other() -> None:
    """Under so wide a bell a wave goes over the whole range, and its width changes nothing."""
    shape = {
        "position_friction_order": 3.0,
        "position_friction_centre_rad": 0.1,
        "position_friction_width_rad": 300.0,
    }

    def missing(data: JointData) -> Float:
        return np.sign(data.dq) * 0.1 * np.cos(3.0 * (data.q - 0.1))

    ground = make_ground(moved_joint(missing, noise_nm=0.02, duration_s=20.0), None, 0)
    (effect,) = parameters_of(ground, [found_effect(ground, PLACE_FRICTION, shape)], ground.baseline()).effects
    width, order = effect["position_friction_width_rad"], effect["position_friction_order"]
    assert width.value == shape["position_friction_width_rad"]
    assert (width.low, width.high) == (-np.inf, np.inf)
    assert order.low < 3.0 < order.high < order.low + 1.0
    factors = [effect["position_friction_cos_nm"], effect["position_friction_sin_nm"]]
    assert [one.value for one in factors] == pytest.approx([0.1, 0.0], abs=0.02)
    assert all(one.high - one.low < 0.05 for one in factors)
