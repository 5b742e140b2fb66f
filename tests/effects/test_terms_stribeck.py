"""Stribeck friction by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.stribeck import TERM
from tests.effects.motion_by_hand import motion_of


@pytest.mark.parametrize(("exponent", "at_twice"), [(1.0, np.exp(-2.0)), (2.0, np.exp(-4.0))])
def test_it_has_fallen_by_e_at_its_speed_either_way(exponent: float, at_twice: float) -> None:
    column = TERM.regressor(motion_of(dq=[-0.05, 0.0, 0.05, 0.1]), (0.05, exponent))[:, 0]
    assert column == pytest.approx([-np.exp(-1.0), 0.0, np.exp(-1.0), at_twice], rel=1e-14)


def test_it_is_one_just_above_rest() -> None:
    assert TERM.regressor(motion_of(dq=[1e-12, -1e-12]), (0.05, 2.0))[:, 0] == pytest.approx([1.0, -1.0])
