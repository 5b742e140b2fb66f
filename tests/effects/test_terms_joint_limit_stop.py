"""Stops by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.joint_limit_stop import TERM
from tests.effects.motion_by_hand import motion_of


def test_stops_push_back_only_where_they_are_touched() -> None:
    motion = motion_of(q=[0.0, 1.0, 1.1, 1.2, -0.6], dq=[1.0, 1.0, 2.0, -1.0, -3.0])
    expected = [
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 2.0, 2.0],
        [4.0, 0.0, -1.0, -4.0],
        [0.0, -1.0, -3.0, -3.0],
    ]
    assert TERM.regressor(motion, (1.0, -0.5, 2.0)) == pytest.approx(np.array(expected))


def test_their_factor_is_the_torque_at_a_tenth_of_a_radian() -> None:
    for exponent in (1.0, 1.5, 3.0):
        torque = TERM.torque((5.0, 2.0, 0.0, 0.0, 1.0, -1.0, exponent), motion_of(q=[1.1, -1.1]))
        assert torque == pytest.approx([5.0, -2.0])
