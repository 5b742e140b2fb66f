"""Compensators by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.unlogged_compensation import DEAD_BAND, SMOOTH, TERM
from tests.effects.arm_motion import DQ, among_three


def test_a_smooth_one_helps_the_motion() -> None:
    torque = TERM.torque((0.3, 0.5, 0.0, SMOOTH), among_three())
    assert torque == pytest.approx(-0.3 * np.tanh(DQ / 0.5))


def test_one_with_a_dead_band_holds_back() -> None:
    torque = TERM.torque((0.3, 0.6, 0.0, DEAD_BAND), among_three())
    assert torque == pytest.approx([0.3, 0.0, 0.0, 0.0, -0.3])


def test_the_shifted_sigmoid_gives_nothing_at_rest() -> None:
    # phi1 / (1 + exp(-phi2 (v + phi3))) - phi1 / (1 + exp(-phi2 phi3)), Gaz et al. (2019)
    phi1, phi2, phi3 = 0.6, 4.0, 0.1
    published = phi1 / (1 + np.exp(-phi2 * (DQ + phi3))) - phi1 / (1 + np.exp(-phi2 * phi3))
    torque = TERM.torque((phi1 / 2, 2 / phi2, phi2 * phi3 / 2, SMOOTH), among_three())
    assert torque == pytest.approx(-published)
    assert torque[2] == 0.0
