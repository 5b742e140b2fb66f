from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulate import (
    IDEAL_SENSORS,
    Compensation,
    HandGuidedPanda,
    JointSettings,
    simulate_hand_guided_panda,
    simulate_joint,
)

MOVED = JointSettings(duration_s=5.0)
IDEAL = HandGuidedPanda(joint=4, moved=MOVED, sensors=(IDEAL_SENSORS,) * 7)


def test_sensor_reads_gravity_less_the_interaction_torque() -> None:
    simulation = simulate_hand_guided_panda(IDEAL, 1)
    log, motion = simulation.log, simulation.truth.motion
    assert log.tau_J is not None
    assert log.gravity is not None
    interaction = log.gravity - log.tau_J
    assert_allclose(interaction[:, 3], motion.interaction_nm, atol=1e-6)
    assert_allclose(np.delete(interaction, 3, axis=1), 0.0, atol=1e-6)
    assert np.ptp(log.gravity[:, 1]) > 0.1


def test_motion_is_that_of_the_single_joint() -> None:
    panda = simulate_hand_guided_panda(IDEAL, 2).log
    bench = simulate_joint(replace(MOVED, sensors=IDEAL_SENSORS), 2).log
    assert_array_equal(panda.dq[:, 3], bench.dq[:, 0])
    assert_allclose(panda.q[:, 3] - panda.q[0, 3], bench.q[:, 0], atol=1e-12)
    assert_array_equal(np.delete(panda.dq, 3, axis=1), 0.0)


def test_log_looks_like_that_of_a_panda() -> None:
    log = simulate_hand_guided_panda(HandGuidedPanda(moved=MOVED), 3).log
    assert log.joint_names == tuple(f"panda_joint{number}" for number in range(1, 8))
    assert log.source.robot == "panda"
    assert log.tau_J is not None
    for joint, step in ((1, 0.0357), (7, 0.006)):
        steps = log.tau_J[:, joint - 1] / step
        assert_allclose(steps, np.rint(steps), atol=1e-6)
    assert (log.dq.std(axis=0) > 0.002).all()
    assert log.tau_compensation is None


def test_external_torque_follows_the_residual() -> None:
    log = simulate_hand_guided_panda(IDEAL, 4).log
    assert log.tau_J is not None
    assert log.gravity is not None
    assert log.tau_ext_hat_filtered is not None
    residual = (log.tau_J - log.gravity)[:, 3]
    assert np.corrcoef(residual, log.tau_ext_hat_filtered[:, 3])[0, 1] > 0.99


def test_compensator_is_logged_on_its_joint() -> None:
    helped = replace(MOVED, compensation=Compensation(coulomb_nm=0.2, viscous_nms_per_rad=0.0))
    log = simulate_hand_guided_panda(HandGuidedPanda(joint=2, moved=helped), 5).log
    assert log.tau_compensation is not None
    assert np.abs(log.tau_compensation).max(axis=0).tolist() == [0.0, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_joint_that_a_panda_does_not_have_is_refused() -> None:
    with pytest.raises(UsageError, match="expected a joint from 1 to 7"):
        HandGuidedPanda(joint=8)
