"""Replay of an arm whose joints were compensated while a hand guided it: the same torques come out again."""

from dataclasses import replace
from functools import cache
from math import inf
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.compensators import EnergyCompensator
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.pipeline import AuditSettings, replay_log
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.simulation import IDEAL_SENSORS, ArmSettings, JointParameters, Simulation, simulate

JOINT = JointParameters(inertia_kg_m2=0.2, coulomb_nm=0.3, viscous_nms_per_rad=0.06)
COMPENSATOR = EnergyCompensator(window=4)
GUIDED = ArmSettings(
    joints=(JOINT,) * 7, sensors=(IDEAL_SENSORS,) * 7, compensator=COMPENSATOR, hand_cycles=True, duration_s=20.0
)


@cache
def guided(*, hand_cycles: bool) -> Simulation:
    return simulate(replace(GUIDED, hand_cycles=hand_cycles), 2)


def replayed(simulation: Simulation, *, cycles_from: str) -> Any:
    settings = AuditSettings(cycles=CycleSettings(cycles_from=cycles_from))
    # The simulated controller knows no limits of a Panda.
    what = ReplaySettings(compensator=COMPENSATOR, max_torque_nm=inf, max_torque_rate_nm_s=inf)
    return replay_log(simulation.log, settings, what)


@pytest.mark.parametrize("cycles_from", ["joint", "hand"])
def test_the_torque_of_the_closed_loop_comes_out_again(cycles_from: str) -> None:
    simulation = guided(hand_cycles=cycles_from == "hand")
    joints = replayed(simulation, cycles_from=cycles_from).replay.joints
    applied: Any = simulation.log.tau_compensation
    found = [joint for joint in joints if joint.replayed is not None]
    assert len(found) >= 6, [joint.reason for joint in joints]
    for joint in found:
        column = applied[:, joint.joint - 1]
        assert np.abs(column).max() > 0.1
        np.testing.assert_allclose(joint.replayed.compensation_nm, column, atol=1e-6)


def test_the_hand_ends_the_cycles_at_the_ticks_at_which_the_controller_did() -> None:
    simulation = guided(hand_cycles=True)
    ticks = np.flatnonzero(np.diff(simulation.truth.compensators["cycle"][:, 0])) + 1
    assert len(ticks) > 5
    for joint in replayed(simulation, cycles_from="hand").replay.joints:
        np.testing.assert_array_equal(joint.history.stop, ticks)
