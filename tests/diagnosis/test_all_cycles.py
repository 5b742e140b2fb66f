"""Shapes go on to where all cycles are fitted best, and no further than the log tells."""

import numpy as np
import pytest

from friction_audit.diagnosis.all_cycles import settled
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.naming import Found
from friction_audit.diagnosis.refine import refine
from friction_audit.diagnosis.shape_steps import steps_of
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.position_dependent_friction import EFFECT as PLACE_FRICTION
from friction_audit.effects.warm_up import EFFECT as WARM_UP
from friction_audit.joint_log import Float
from tests.diagnosis.found_effect import found_effect
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.toy_candidates import BUMP, altered

PLACE, WIDTH = 0.2, 0.2


def bump(data: JointData) -> Float:
    return 0.1 * np.exp(-(((data.q - PLACE) / WIDTH) ** 2))


def left(ground: Ground, one: Found) -> float:
    columns = np.hstack([ground.base, one.columns])
    return float(np.sum((ground.y - columns @ np.linalg.lstsq(columns, ground.y)[0]) ** 2))


def test_without_noise_a_shape_is_found_from_a_tenth_of_the_range_away() -> None:
    ground = make_ground(moved_joint(bump, duration_s=20.0), None, 0)
    (one,) = settled(ground, [found_effect(ground, BUMP, {"place_rad": 0.3, "width_rad": 0.3})], ground.baseline())
    assert one.shape == pytest.approx({"place_rad": PLACE, "width_rad": WIDTH}, rel=1e-3)


def test_all_cycles_have_no_better_shape_though_the_working_ones_do() -> None:
    ground = make_ground(moved_joint(bump, noise_nm=0.03, duration_s=20.0), None, 0)
    shape = refine(
        BUMP, {"place_rad": 0.3, "width_rad": 0.2}, BUMP.grid(ground.data), ground, ground.baseline(), ground.base
    )
    first = found_effect(ground, BUMP, shape)
    (one,) = settled(ground, [first], ground.baseline())
    assert left(ground, one) < left(ground, first)
    for step in steps_of(ground, [one], ground.baseline()).shapes[0].values():
        assert abs(step.value) < 0.01 * (step.high - step.low)


def test_what_the_log_does_not_tell_stays() -> None:
    """Under so wide a bell a wave goes over the whole range, and its width changes nothing."""

    def missing(data: JointData) -> Float:
        return np.sign(data.dq) * 0.1 * np.cos(3.0 * (data.q - 0.1))

    ground = make_ground(moved_joint(missing, noise_nm=0.02, duration_s=20.0), None, 0)
    shape = {"position_friction_order": 3.1, "position_friction_centre_rad": 0.1, "position_friction_width_rad": 300.0}
    (one,) = settled(ground, [found_effect(ground, PLACE_FRICTION, shape)], ground.baseline())
    assert one.shape["position_friction_width_rad"] == 300.0
    assert one.shape["position_friction_order"] == pytest.approx(3.0, abs=0.08)


def test_a_time_constant_stays() -> None:
    ground = make_ground(moved_joint(bump, duration_s=40.0), None, 0)
    one = found_effect(ground, WARM_UP, {"warm_up_time_s": 15.0, "warm_up_per_k": 1e-6})
    assert settled(ground, [one], ground.baseline()) == [one]


def test_no_step_leads_to_what_is_not_possible() -> None:
    ground = make_ground(moved_joint(bump, noise_nm=0.01, duration_s=20.0), None, 0)
    first = found_effect(
        ground,
        altered(BUMP, admissible=lambda _factors, shape: shape["place_rad"] >= 0.25),
        {"place_rad": 0.26, "width_rad": 0.2},
    )
    (one,) = settled(ground, [first], ground.baseline())
    assert one.shape["place_rad"] >= 0.25
    assert left(ground, one) < left(ground, first)
