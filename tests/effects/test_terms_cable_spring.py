"""Cable by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.cable_spring import TERM
from tests.effects.motion_by_hand import motion_of


def test_it_pulls_beyond_its_free_stretch_and_hardens() -> None:
    motion = motion_of(q=[0.3, 0.5, 0.8, -0.2, -0.7])
    expected = [[0.0, 0.0], [0.0, 0.0], [0.3, 0.027], [-0.2, -0.008], [-0.7, -0.343]]
    assert TERM.regressor(motion, (0.25, 0.25))[:, :2] == pytest.approx(np.array(expected))


def test_a_linear_cable_about_another_centre_is_one_with_a_preload() -> None:
    motion = motion_of(q=np.linspace(-1.0, 1.0, 11))
    elsewhere = TERM.torque((0.4, 0.0, 0.0, 0.3, 0.0), motion)
    assert TERM.torque((0.4, 0.0, -0.12, 0.0, 0.0), motion) == pytest.approx(elsewhere)


def test_a_free_stretch_over_one_end_makes_a_tether() -> None:
    torque = TERM.torque((2.0, 0.0, 0.0, -10.0, 10.5), motion_of(q=[-1.0, 0.0, 0.5, 0.7]))
    assert torque == pytest.approx([0.0, 0.0, 0.0, 0.4])
