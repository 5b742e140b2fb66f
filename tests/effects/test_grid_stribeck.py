"""Stribeck friction against friction that is curved otherwise."""

import numpy as np
import pytest

from friction_audit.effects import nonlinear_viscous, stribeck
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import baseline, two_sines

DATA = two_sines()
V = DATA.dq
FALLING = {
    "exponential": np.exp(-np.abs(V) / 0.1),
    "lorentzian": 1.0 / (1.0 + (V / 0.1) ** 2),
    "line to zero": np.maximum(1.0 - np.abs(V) / 0.2, 0.0),
}
RISING = {
    "root": np.sqrt(np.abs(V)),
    "drag": V**2,
    "cube": np.abs(V) ** 3,
    "logarithm": np.arcsinh(np.abs(V) / 0.2),
    "smoothed by tanh": np.tanh(np.abs(V) / 0.1),
    "smoothed by the arc tangent": np.arctan(np.abs(V) / 0.1),
}


@pytest.mark.parametrize("form", FALLING)
def test_friction_that_falls_is_stribeck(form: str) -> None:
    torque = np.sign(V) * FALLING[form]
    own = share_explained(stribeck.EFFECT, DATA, torque)
    assert own > 0.97
    assert 1.0 - share_explained(nonlinear_viscous.EFFECT, DATA, torque) > 3.0 * (1.0 - own)


@pytest.mark.parametrize("form", RISING)
def test_friction_that_rises_in_a_curve_is_not(form: str) -> None:
    torque = np.sign(V) * RISING[form]
    own = share_explained(nonlinear_viscous.EFFECT, DATA, torque)
    assert own > 0.98
    assert 1.0 - share_explained(stribeck.EFFECT, DATA, torque) > 3.0 * (1.0 - own)


def test_signs_tell_the_two_apart() -> None:
    fading = {"stribeck_speed_rad_s": 0.1, "stribeck_exponent": 1.0}
    assert stribeck.EFFECT.admissible(np.array([0.1]), fading)
    assert not stribeck.EFFECT.admissible(np.array([-0.1]), fading)
    thinning, drag = ({"curved_viscous_exponent": n, "curved_viscous_speed_rad_s": 0.01} for n in (0.5, 2.0))
    assert not nonlinear_viscous.EFFECT.admissible(np.array([-0.1]), thinning)
    assert nonlinear_viscous.EFFECT.admissible(np.array([-0.1]), drag)


def test_the_speeds_tried_scale_with_those_of_the_log() -> None:
    tried = [shape["stribeck_speed_rad_s"] for shape in stribeck.EFFECT.grid(DATA)]
    fast = float(np.percentile(np.abs(V[DATA.used]), 95))
    assert min(tried) == pytest.approx(0.01 * fast)
    assert max(tried) == pytest.approx(0.4 * fast)
    assert stribeck.EFFECT.not_identifiable(DATA, baseline(DATA)) is None
