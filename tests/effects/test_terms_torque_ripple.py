"""Ripple by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.torque_ripple import TERM
from tests.effects.motion_by_hand import motion_of


def test_it_repeats_with_the_position_whatever_the_direction() -> None:
    turn = 2.0 * np.pi / 100.0
    motion = motion_of(q=[0.0, turn / 4, turn / 2, turn, 7 * turn], dq=[1.0, -1.0, 0.0, -2.0, 3.0])
    expected = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0], [1.0, 0.0]]
    assert TERM.regressor(motion, (100.0,)) == pytest.approx(np.array(expected), abs=1e-12)
