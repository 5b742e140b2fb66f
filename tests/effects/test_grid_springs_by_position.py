"""Cables pull over the range, stops near its ends."""

import numpy as np
import pytest

from friction_audit.effects import cable_spring, joint_limit_stop
from friction_audit.joint_log import Float
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import baseline, two_sines

DATA = two_sines()
Q, V = DATA.q, DATA.dq
CABLES = {
    "linear about elsewhere": 0.4 * (Q - 0.3),
    "hardening": 0.2 * Q + 0.3 * Q**3,
    "slack": np.sign(Q) * np.maximum(np.abs(Q) - 0.25, 0.0),
    "tether": np.maximum(Q - 0.1, 0.0),
}
STOPS = {
    "both": 20.0 * (np.maximum(Q - 0.9, 0.0) - np.maximum(-0.95 - Q, 0.0)),
    "upper": 20.0 * np.maximum(Q - 0.85, 0.0),
    "lower": -20.0 * np.maximum(-0.9 - Q, 0.0),
    "quadratic": 100.0 * np.maximum(Q - 0.8, 0.0) ** 2,
    "damped": (20.0 * (Q - 0.85) + 0.4 * V) * (Q > 0.85),
}


@pytest.mark.parametrize("form", CABLES)
def test_cables(form: str) -> None:
    torque: Float = CABLES[form]
    own = share_explained(cable_spring.EFFECT, DATA, torque)
    assert own > 0.9
    assert share_explained(joint_limit_stop.EFFECT, DATA, torque) < own
    assert share_explained(cable_spring.EFFECT, DATA, -torque) < 0.7


@pytest.mark.parametrize("form", STOPS)
def test_stops(form: str) -> None:
    torque: Float = STOPS[form]
    own = share_explained(joint_limit_stop.EFFECT, DATA, torque)
    assert own > 0.95
    # A tether that hardens is a quadratic stop to within a hundredth, and always its alternative.
    assert share_explained(cable_spring.EFFECT, DATA, torque) < own + (0.01 if form == "quadratic" else 0.0)
    assert share_explained(joint_limit_stop.EFFECT, DATA, -torque) < 0.5


def test_a_free_stretch_can_be_refined() -> None:
    """Values of the grid that differ by rounding only would leave no room between neighbours."""
    grid = [shape for shape in cable_spring.EFFECT.grid(DATA) if shape]
    for name in grid[0]:
        values = np.unique([shape[name] for shape in grid])
        assert np.diff(values).min() > 1e-3


def test_a_straight_spring_has_no_number_but_its_factors() -> None:
    assert {} in cable_spring.EFFECT.grid(DATA)
    columns = cable_spring.EFFECT.regressor(DATA, baseline(DATA), {})
    torque = 0.4 * (Q - 0.3)
    np.testing.assert_allclose(columns @ [0.4, 0.0, -0.12], torque, atol=1e-12)
