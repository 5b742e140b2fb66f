"""The floor is the noise, whatever smooth curve the model lacks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.floor import beside_wanted_curves, noise_floor
from friction_audit.diagnosis.ground import make_ground
from friction_audit.effects.joint_data import JointData
from tests.diagnosis.moved_joint import moved_joint


def rms(residual: np.ndarray) -> float:
    return float(np.sqrt(np.mean(residual**2)))


def test_of_a_complete_model_it_is_what_the_model_leaves() -> None:
    ground = make_ground(moved_joint(noise_nm=0.02), None, 0)
    floor = noise_floor(ground, ground.curves)
    assert floor == pytest.approx(0.02, rel=0.05)
    assert floor <= rms(ground.residual()[ground.locked]) * (1.0 + 1e-9)


def test_a_curve_that_the_model_lacks_does_not_raise_it() -> None:
    ground = make_ground(moved_joint(lambda data: 0.2 * np.cos(2 * data.q), noise_nm=0.02), None, 0)
    assert rms(ground.residual()[ground.locked]) > 0.05
    assert noise_floor(ground, ground.curves) == pytest.approx(0.02, rel=0.1)


def test_few_cycles_teach_one_curve_where_they_do_not_teach_all() -> None:
    def excess(data: JointData) -> np.ndarray:
        return 0.15 * np.sign(data.dq) * np.exp(-np.abs(data.dq) / 0.2)

    ground = make_ground(moved_joint(excess, noise_nm=0.01, duration_s=14.0), None, 0)
    assert rms(ground.residual()[ground.locked]) > 0.02
    assert noise_floor(ground, ground.curves) < 0.7 * rms(ground.residual()[ground.locked])


def test_what_no_curve_learns_it_takes_for_noise_until_an_effect_explains_it() -> None:
    ground = make_ground(moved_joint(lambda data: 0.1 * np.sin(40 * data.q), noise_nm=0.02), None, 0)
    wave = ground.rows.of(np.sin(40 * ground.data.q)[:, None])
    assert noise_floor(ground, ground.curves) > 0.05
    assert noise_floor(ground, ground.curves, wave) == pytest.approx(0.02, rel=0.05)


def test_slow_noise_is_left_as_it_is_and_what_something_missing_bends_is_taken_off() -> None:
    bare = moved_joint(duration_s=40.0)
    noise = lfilter([0.2], [1.0, -0.98], np.random.default_rng(0).standard_normal(len(bare.t)))
    slow, bent = (
        make_ground(replace(bare, torque=bare.torque + 0.02 * noise + size * np.cos(2 * bare.q)), None, 0)
        for size in (0.0, 0.2)
    )
    left = rms(slow.residual())
    assert rms(beside_wanted_curves(slow)) == pytest.approx(left, rel=0.01)
    assert rms(bent.residual()) > 2.0 * left
    assert rms(beside_wanted_curves(bent)) < 1.2 * left


def test_nothing_of_the_declared_model_is_left_beside_bent_curves() -> None:
    exact = make_ground(moved_joint(duration_s=40.0), None, 0)
    assert beside_wanted_curves(exact) == pytest.approx(0.0, abs=1e-9)
