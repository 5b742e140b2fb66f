"""Friction by position by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.position_dependent_friction import TERM
from tests.effects.motion_by_hand import motion_of

WIDE = 1e6


def test_a_wave_turns_with_the_direction() -> None:
    motion = motion_of(q=[0.1, 0.1, 0.1, 0.1 + np.pi / 6], dq=[2.0, -0.1, 0.0, 1.0])
    expected = [[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]
    assert TERM.regressor(motion, (3.0, 0.1, WIDE)) == pytest.approx(np.array(expected), abs=1e-10)


def test_a_patch_is_a_bell_about_its_centre() -> None:
    motion = motion_of(q=[0.5, 0.7, 0.3, 2.5], dq=[1.0, 1.0, -1.0, 1.0])
    column = TERM.regressor(motion, (0.0, 0.5, 0.2))[:, 0]
    assert column == pytest.approx([1.0, np.exp(-0.5), -np.exp(-0.5), 0.0], abs=1e-12)
