"""Fig. 12: seven joints, cycles of the hand."""

import numpy as np
import pytest

from friction_audit.reproduce.arm import SLOPE_BOUND, arm_leaves_by, cyclic_energies, negative_share, slope_ratios
from tests.reproduce.conftest import Check, simulated


def test_all_coefficients_are_updated_at_once(claims: Check) -> None:
    claim = claims("12")["the coefficients of all joints are updated at the same instants"]
    assert claim.value == 0
    assert claim.holds


def test_the_energy_of_the_arm_stops_rising(claims: Check) -> None:
    claim = claims("12")["after two cycles the net energy of the arm stops rising"]
    assert claim.value < SLOPE_BOUND == 0.1
    assert claim.holds


def test_joints_are_counted(claims: Check) -> None:
    claim = claims("12")["and so does that of every single joint"]
    assert claim.ours.partition(" joints")[0] in ("7 of 7", "6 of 7")
    assert claim.holds == (claim.value < SLOPE_BOUND)


def test_whether_the_energy_is_kept_is_told_with_the_reason(claims: Check) -> None:
    claim = claims("12")["and keeps its value for the remaining cycles"]
    assert claim.value == arm_leaves_by(simulated("12")["fig12"][0])
    assert claim.holds == (claim.value < 0.25)
    assert "negative coefficient" in claim.note
    assert 0.05 < negative_share(simulated("12")["fig12"][0]) < 0.5


def test_cycles_end_together_and_often() -> None:
    t, energies = cyclic_energies(simulated("12")["fig12"][0])
    assert energies.shape == (len(t), 7)
    assert len(t) > 5


def test_slopes_by_hand() -> None:
    t = np.array([1.0, 2.0, 3.0, 4.0])
    energies = np.array([[1.0, 1.0], [2.0, 2.0], [2.0, 3.0], [2.0, 4.0]])
    assert slope_ratios((t, energies)) == pytest.approx([0.0, 1.0], abs=1e-12)
