"""Fig. 12: seven joints, cycles of the hand."""

import numpy as np
import pytest

from friction_audit.reproduce.fig12 import SLOPE_BOUND, cyclic_energies, slope_ratios
from tests.reproduce.conftest import Check, simulated


def test_all_coefficients_are_updated_at_once(claims: Check) -> None:
    claim = claims("12")["the coefficients of all joints are updated at the same instants"]
    assert claim.value == 0
    assert claim.holds


def test_the_energy_of_the_arm_stops_rising(claims: Check) -> None:
    claim = claims("12")["after two cycles the net energy of the arm stops rising"]
    assert claim.value < SLOPE_BOUND == 0.1
    assert claim.holds


def test_so_do_those_of_the_joints_of_this_hand(claims: Check) -> None:
    claim = claims("12")["and so does that of every single joint"]
    assert claim.value < SLOPE_BOUND
    assert claim.ours.startswith("7 of 7 joints")


def test_cycles_end_together_and_often() -> None:
    t, energies = cyclic_energies(simulated("12")["fig12"][0])
    assert energies.shape == (len(t), 7)
    assert len(t) > 5


def test_slopes_by_hand() -> None:
    t = np.array([1.0, 2.0, 3.0, 4.0])
    energies = np.array([[1.0, 1.0], [2.0, 2.0], [2.0, 3.0], [2.0, 4.0]])
    assert slope_ratios((t, energies)) == pytest.approx([0.0, 1.0], abs=1e-12)
