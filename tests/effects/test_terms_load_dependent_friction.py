"""Friction by load, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.effects.terms.load_dependent_friction import TERM
from tests.effects.arm_motion import among_three

LOADED = replace(among_three(), load=np.array([-4.0, 4.0, 4.0, -4.0, 2.0]), rest=np.array([-1.0, -1.0, 0.0, 1.0, 1.0]))
"""Transmitted: -5, 3, 4, -3, 3 N m; the joint moves backwards twice, rests, moves forwards twice."""


def test_it_resists_motion_by_the_size_of_what_is_transmitted() -> None:
    assert TERM.torque((0.1, 0.0, 1.0, 0.0, 0.0), LOADED) == pytest.approx([-0.5, -0.3, 0.0, 0.3, 0.3])


def test_squared() -> None:
    assert TERM.torque((0.1, 0.0, 2.0, 0.0, 0.0), LOADED) == pytest.approx([-2.5, -0.9, 0.0, 0.9, 0.9])


def test_the_direction_of_the_power_is_the_load_itself_in_motion() -> None:
    half = TERM.torque((0.1, 0.05, 1.0, 1.0, 0.0), LOADED)
    power = np.sign(np.array([-5.0, 3.0, 4.0, -3.0, 3.0]) * LOADED.dq)
    level = 0.1 * np.array([5.0, 3.0, 4.0, 3.0, 3.0]) * (1.0 + 0.5 * power)
    moving = LOADED.dq != 0
    assert half[moving] == pytest.approx((np.sign(LOADED.dq) * level)[moving])


def test_without_a_known_load_what_the_motion_takes_is_all() -> None:
    bare = replace(LOADED, load=None)
    assert TERM.torque((0.1, 0.0, 1.0, 0.0, 0.0), bare) == pytest.approx([-0.1, -0.1, 0.0, 0.1, 0.1])


def test_the_weight_alone_may_be_the_load() -> None:
    assert TERM.torque((0.1, 0.0, 1.0, 0.0, 1.0), LOADED) == pytest.approx([-0.4, -0.4, 0.0, 0.4, 0.2])
