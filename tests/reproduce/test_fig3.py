"""Fig. 3: what goes in is stored or dissipated."""

import numpy as np

from friction_audit.reproduce.viscous import CLOSURE_BOUND, MINIMA_BOUND, minima
from tests.reproduce.conftest import Check


def test_net_energy_is_kinetic_and_dissipated(claims: Check) -> None:
    claim = claims("3")["net energy = kinetic + dissipated energy, at every sample"]
    assert 0.0 < claim.value < CLOSURE_BOUND == 1e-5
    assert claim.holds


def test_dissipation_never_falls(claims: Check) -> None:
    claim = claims("3")["the dissipated energy never falls"]
    assert claim.value >= 0.0
    assert claim.holds


def test_minima_rise_by_the_dissipation_of_the_cycle(claims: Check) -> None:
    claim = claims("3")["the minima of the net energy rise by what the cycle dissipated"]
    assert claim.value < MINIMA_BOUND == 1e-4
    assert claim.ours.startswith("3 cycles")
    assert claim.holds


def test_minima_by_hand() -> None:
    dissipated = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    energy = dissipated + np.array([0.0, 3.0, 0.0, 3.0, 0.0, 3.0])
    assert minima(energy, dissipated) == (2, 0.0)
    assert minima(1.1 * energy, dissipated)[1] > 0.09


def test_without_a_cycle_no_minimum_rises() -> None:
    count, error = minima(np.arange(5.0), np.arange(5.0))
    assert (count, error) == (0, np.inf)
