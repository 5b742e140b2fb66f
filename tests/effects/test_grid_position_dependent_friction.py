"""Waves and patches of friction wherever they lie."""

import numpy as np
import pytest

from friction_audit.effects import position_dependent_friction, torque_ripple
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import two_sines

DATA = two_sines()
Q, S = DATA.q, np.sign(DATA.dq)


@pytest.mark.parametrize("order", [1.5, 3.0, 4.4, 7.7, 11.0])
@pytest.mark.parametrize("phase", [0.0, 1.0])
def test_a_wave_of_any_order_and_phase_is_found(order: float, phase: float) -> None:
    torque = S * np.cos(order * Q + phase)
    assert share_explained(position_dependent_friction.EFFECT, DATA, torque) > 0.85
    assert share_explained(torque_ripple.EFFECT, DATA, torque) < 0.05


@pytest.mark.parametrize("centre", [-0.6, -0.11, 0.23, 0.5])
@pytest.mark.parametrize("width", [0.1, 0.2, 0.4])
def test_a_patch_is_found_anywhere(centre: float, width: float) -> None:
    torque = S * np.maximum(1.0 - np.abs(Q - centre) / width, 0.0)
    assert share_explained(position_dependent_friction.EFFECT, DATA, torque) > 0.7
