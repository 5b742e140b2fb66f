"""Whole cycles are locked away, enough of them, everywhere, and the same ones again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.diagnosis.split import split_cycles
from friction_audit.errors import AnalysisError


@given(m=st.integers(4, 80), seed=st.integers(0, 1000))
def test_split_is_complete_large_enough_and_repeatable(m: int, seed: int) -> None:
    cycles, speed = 3 * np.arange(m), np.random.default_rng(seed).uniform(0.1, 1.0, m)
    split = split_cycles(cycles, speed, seed)
    assert sorted([*split.working, *split.locked]) == cycles.tolist()
    assert len(split.locked) >= 0.3 * m
    assert len(split.working) >= 2
    again = split_cycles(cycles, speed, seed)
    assert np.array_equal(again.locked, split.locked)
    if m >= 20:
        assert split.locked[0] < cycles[m // 2] < split.locked[-1]


def test_too_few_cycles_are_refused() -> None:
    with pytest.raises(AnalysisError, match="3 cycles"):
        split_cycles(np.arange(3), np.ones(3), 0)
