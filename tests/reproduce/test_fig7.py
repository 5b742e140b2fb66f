"""Fig. 7: over-compensation, and the passivity controller that ends it."""

import numpy as np
import pytest

from friction_audit.reproduce.viscous import tolerance_j
from tests.reproduce.conftest import Check, simulated


def test_the_energy_falls_below_zero_without_controller(claims: Check) -> None:
    claim = claims("7")["over-compensated without passivity controller, the energy falls below zero"]
    # Cycles 2 to 5 inject half of what cycle 1 dissipated each.
    assert claim.value == pytest.approx(1.0 - 4 * 0.5, abs=0.02)
    assert claim.holds


def test_never_with_it_but_for_a_tick(claims: Check) -> None:
    claim = claims("7")["with it, the energy never falls below zero"]
    (guarded,) = simulated("7")["fig7"]
    motion = guarded.truth.motion
    tick = np.abs(motion.interaction_nm * motion.dq).max() * 1e-3
    assert tolerance_j(guarded) == pytest.approx(2.0 * tick), "hand and joint weigh the same"
    assert -tolerance_j(guarded) <= claim.value < 0.0
    assert claim.holds


def test_the_controller_acts_in_the_fourth_cycle_only(claims: Check) -> None:
    claim = claims("7")["the controller acts in the fourth cycle, and in no other"]
    assert claim.value == 4
    assert claim.holds


def test_its_damping_is_finite(claims: Check) -> None:
    claim = claims("7")["the adaptive damping is finite and dissipates what was injected too much"]
    assert 0.0 < claim.value <= 50.0
    assert claim.holds


def test_it_takes_what_the_fourth_cycle_injected() -> None:
    (guarded,) = simulated("7")["fig7"]
    traces = guarded.truth.compensators
    first = np.flatnonzero(np.diff(traces["cycle"][:, 0]))[0] + 1
    # Half of the friction too much, over a cycle like the first.
    assert traces["dissipated_j"][-1, 0] == pytest.approx(0.5 * traces["energy_j"][first, 0], rel=0.02)


def test_the_coefficient_returns(claims: Check) -> None:
    claim = claims("7")["then the coefficient returns to the true one, from the energy that the controller took"]
    assert claim.value < 1e-2
    assert claim.holds
    assert simulated("7")["fig7"][0].truth.compensators["viscous_nms_per_rad"][-1, 0] == pytest.approx(0.2, rel=1e-2)
