"""Replay of an arm whose joints were compensated while a hand guided it: the same torques come out again."""

from math import inf
from typing import Any

import numpy as np

from friction_audit.compensation.compensators import EnergyCompensator
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.pipeline import AuditSettings, replay_log
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.simulation import IDEAL_SENSORS, ArmSettings, simulate
from tests.compensation.bench import JOINT

COMPENSATOR = EnergyCompensator(window=4)
GUIDED = ArmSettings(
    joints=(JOINT,) * 7, sensors=(IDEAL_SENSORS,) * 7, compensator=COMPENSATOR, hand_cycles=True, duration_s=20.0
)


def test_the_hand_ends_the_cycles_as_it_did_and_the_torque_of_the_closed_loop_comes_out_again() -> None:
    simulation: Any = simulate(GUIDED, 2)
    # The simulated controller knows no limits of a Panda.
    what = ReplaySettings(compensator=COMPENSATOR, max_torque_nm=inf, max_torque_rate_nm_s=inf)
    found = replay_log(simulation.log, AuditSettings(cycles=CycleSettings(cycles_from="hand")), what)
    ticks = np.flatnonzero(np.diff(simulation.truth.compensators["cycle"][:, 0])) + 1
    assert len(ticks) > 5
    joints: Any = found.replay.joints
    for joint in joints:
        np.testing.assert_array_equal(joint.history.stop, ticks)
        column = simulation.log.tau_compensation[:, joint.joint - 1]
        assert np.abs(column).max() > 0.1
        np.testing.assert_allclose(joint.replayed.compensation_nm, column, atol=1e-6)
