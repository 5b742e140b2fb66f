"""Step of friction by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.friction_step import TERM
from tests.effects.motion_by_hand import motion_of


def test_a_step_begins_at_its_moment() -> None:
    columns = TERM.regressor(motion_of(t=[0.0, 1.0, 2.0, 3.0], dq=[2.0, 2.0, -2.0, 0.5]), (2.0, 0.0))
    assert columns == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.0], [-1.0, -2.0], [1.0, 0.5]]))


def test_a_ramp_is_half_over_at_its_moment() -> None:
    column = TERM.regressor(motion_of(t=[0.0, 3.0, 4.0, 5.0, 9.0], dq=np.ones(5)), (4.0, 4.0))[:, 0]
    assert column == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])
