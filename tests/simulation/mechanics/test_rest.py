from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.simulation import IDEAL_SENSORS, BenchSettings, Hidden, simulate
from friction_audit.simulation.effects.structure import Backlash, JointElasticity

SOFT = JointElasticity(compliance_rad_per_nm=2e-3)
STILL = BenchSettings(sensors=(IDEAL_SENSORS,), gravity_nm=8.0, gravity_phase_rad=1.0, logs_sensor=True, duration_s=0.4)
LOAD_NM = 8.0 * np.sin(1.0)
WITH_ONE_JOINT = [
    (Hidden(joint_elasticity=SOFT), 2e-3 * LOAD_NM),
    (Hidden(backlash=Backlash(gap_rad=4e-3)), 2e-3 + 1e-4 * LOAD_NM),
    (Hidden(joint_elasticity=SOFT, backlash=Backlash(gap_rad=4e-3)), 2e-3 + 2e-3 * LOAD_NM),
]


@pytest.mark.parametrize(("hidden", "twist"), WITH_ONE_JOINT, ids=["elastic", "backlash", "both"])
def test_load_rests_on_a_twisted_transmission(hidden: Hidden, twist: float) -> None:
    motion = simulate(replace(STILL, hidden=(hidden,)), 1).truth.motion
    assert_allclose(motion.inner_q[0] - motion.q[0], twist, rtol=1e-12)
    assert_allclose(motion.interaction_nm, 0.0, atol=1e-9)
    assert_allclose(motion.dq, 0.0, atol=1e-9)


@pytest.mark.parametrize("hidden", [hidden for hidden, _ in WITH_ONE_JOINT], ids=["elastic", "backlash", "both"])
def test_link_of_a_driven_joint_sags_before_the_recording_begins(hidden: Hidden) -> None:
    # The weight is that of the sagged place: not quite what the twist was made for.
    motion = simulate(replace(STILL, hidden=(hidden,), driven=True), 1).truth.motion
    assert motion.q[0, 0] < -1e-3
    assert_allclose(motion.dq, 0.0, atol=2e-3)
    assert_allclose(motion.interaction_nm, 0.0, atol=0.1)
