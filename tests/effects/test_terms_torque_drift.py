"""Drift by hand, and what share of a random walk it catches."""

import numpy as np
import pytest

from friction_audit.effects.terms.torque_drift import TERM
from tests.effects.motion_by_hand import motion_of

ALL = (0.0,)


def test_it_begins_at_nothing_and_the_first_wave_ends_at_one() -> None:
    columns = TERM.regressor(motion_of(t=[100.0, 160.0, 220.0]), ALL)
    assert columns[0] == pytest.approx(0.0)
    assert columns[1] == pytest.approx(np.sin(np.pi * np.array([0.25, 0.75, 1.25, 1.75])))
    assert columns[2] == pytest.approx([1.0, -1.0, 1.0, -1.0])


@pytest.mark.parametrize("waves", [1, 2, 3, 4])
def test_of_the_slowest_waves_the_others_are_nothing(waves: int) -> None:
    motion = motion_of(t=[100.0, 160.0, 220.0])
    few, every = TERM.regressor(motion, (float(waves),)), TERM.regressor(motion, ALL)
    assert np.array_equal(few[:, :waves], every[:, :waves])
    assert not few[:, waves:].any()


def test_it_stands_still_in_a_log_of_one_moment() -> None:
    assert np.all(TERM.regressor(motion_of(t=[5.0, 5.0]), ALL) == 0.0)


def test_it_catches_a_ramp_and_most_of_a_random_walk() -> None:
    # A ramp is sum of 2 (-1)^(i+1) / ((i - 1/2) pi)^2 waves, a random walk on average of 1 / ((i - 1/2) pi)^2 each.
    t = np.linspace(0.0, 1.0, 2001)
    columns = TERM.regressor(motion_of(t=t), ALL)
    rng = np.random.default_rng(0)
    walks = np.cumsum(rng.normal(size=(2001, 200)), axis=0)
    for signal, share in ((t[:, None], 0.999), (walks, 0.94)):
        left = signal - columns @ np.linalg.lstsq(columns, signal)[0]
        assert 1.0 - np.sum(left**2) / np.sum(signal**2) > share
