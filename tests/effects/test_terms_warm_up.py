"""Warm-up by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.warm_up import TERM
from tests.effects.motion_by_hand import motion_of


def test_it_fades_from_the_start_of_the_log() -> None:
    columns = TERM.regressor(motion_of(t=[50.0, 80.0, 110.0], dq=[0.5, -2.0, 0.0]), (30.0, 0.0))
    expected = [[1.0, 0.5], [-np.exp(-1.0), -2.0 * np.exp(-1.0)], [0.0, 0.0]]
    assert columns == pytest.approx(np.array(expected))


def test_it_fades_with_a_temperature() -> None:
    motion = motion_of(dq=[1.0, 1.0, -1.0], temperature=[25.0, 35.0, 15.0])
    columns = TERM.regressor(motion, (1e9, 0.1))
    assert columns[:, 0] == pytest.approx([1.0, np.exp(-1.0), -np.exp(1.0)], rel=1e-6)


def test_without_a_temperature_only_time_counts() -> None:
    motion = motion_of(dq=[1.0, 1.0])
    assert np.array_equal(TERM.regressor(motion, (10.0, 0.5)), TERM.regressor(motion, (10.0, 0.0)))
