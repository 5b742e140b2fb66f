"""Cables pull over the range, stops near its ends."""

import numpy as np
import pytest

from friction_audit.discrepancy.candidates import cable_spring, joint_limit_stop
from friction_audit.joint_log import Float
from tests.discrepancy.candidates.explained import share_explained
from tests.discrepancy.candidates.joint_data_by_hand import two_sines

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
    own = share_explained(cable_spring.CANDIDATE, DATA, torque)
    assert own > 0.9
    assert share_explained(joint_limit_stop.CANDIDATE, DATA, torque) < own
    assert share_explained(cable_spring.CANDIDATE, DATA, -torque) < 0.7


@pytest.mark.parametrize("form", STOPS)
def test_stops(form: str) -> None:
    torque: Float = STOPS[form]
    own = share_explained(joint_limit_stop.CANDIDATE, DATA, torque)
    assert own > 0.93
    assert share_explained(cable_spring.CANDIDATE, DATA, torque) < own
    assert share_explained(joint_limit_stop.CANDIDATE, DATA, -torque) < 0.5
