"""Loops that ran away."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from friction_audit.compensation.compensators import EnergyCompensator, FixedCompensation, Guard, TorqueRegulation
from friction_audit.compensation.controller import REVERSALS, SPEED_BOUND_RAD_S, TORQUE_BOUND_NM
from friction_audit.compensation.replay import run
from friction_audit.joint_log import Float
from tests.compensation.competitor_bench import feed

T: Float = np.arange(500.0) * 1e-3
DQ: Float = np.sin(T)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1.1 * SPEED_BOUND_RAD_S])
def test_a_speed_that_is_none_silences_for_good(bad: float) -> None:
    dq = DQ.copy()
    dq[200] = bad
    traces = run(FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.0), T, dq, np.ones_like(T))
    assert np.all(traces["u_nm"][50:200] == 0.3)
    assert np.all(traces["u_nm"][200:] == 0.0)
    assert_array_equal(traces["unstable"], np.arange(500) >= 200)
    assert np.all(np.isfinite(traces["energy_j"]))


@pytest.mark.parametrize("bad", [np.nan, -np.inf, 1.1 * TORQUE_BOUND_NM])
def test_a_torque_that_is_none_does_not_reach_the_ledgers(bad: float) -> None:
    torque = np.ones_like(T)
    torque[300] = bad
    traces = run(EnergyCompensator(), T, DQ, torque)
    assert_array_equal(traces["unstable"], np.arange(500) >= 300)
    assert_array_equal(traces["energy_j"][300:], traces["energy_j"][299])


def test_its_own_torque_is_watched_too() -> None:
    regulation = TorqueRegulation(inertia_kg_m2=1.0, desired_inertia_kg_m2=1e-3)
    torque, memory = feed(regulation, 0.0, [1.0, 5.0, 20.0, 1.0])
    assert torque == pytest.approx([999.0, 4995.0, 0.0, 0.0])
    assert memory["unstable_tick"] == 2
    assert memory["ticks"] == 4


def test_turning_back_at_the_limit_tick_by_tick_is_no_control() -> None:
    held = TorqueRegulation(inertia_kg_m2=1.0, desired_inertia_kg_m2=0.1, guard=Guard(max_torque_nm=1.0))
    sides = np.where(np.arange(200) % 2, 1.0, -1.0)
    torque, memory = feed(held, 0.0, sides)
    assert memory["unstable_tick"] == pytest.approx(REVERSALS, abs=1)
    assert_array_equal(torque[REVERSALS + 2 :], 0.0)
