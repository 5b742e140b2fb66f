"""What the audit makes of an arm's log."""

import numpy as np
import pytest

from friction_audit.pipeline import AuditSettings, Estimate, estimate_log
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.simulation import ArmSettings, Simulation, simulate
from friction_audit.simulation.motion import intend_joints
from friction_audit.simulation.panda_joint import PANDA_JOINTS
from friction_audit.simulation.settings import make_streams

COULOMB = np.array([joint.coulomb_nm for joint in PANDA_JOINTS])
DRIVEN = ArmSettings(driven=True, duration_s=15.0)
SEED = 3


@pytest.fixture(scope="module")
def driven() -> Simulation:
    return simulate(DRIVEN, SEED)


def coulomb(estimate: Estimate) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([joint.coulomb.value for joint in estimate.friction.joints])


def test_driven_arm_follows_its_command(driven: Simulation) -> None:
    motion = driven.truth.motion
    command = intend_joints(DRIVEN.servo.motion, 7, len(motion.t) - 1, 1e-3, make_streams(SEED, 7).person)
    error = motion.q - command.position - np.array(DRIVEN.pose_rad)
    assert np.abs(error).max() < 0.03
    assert (np.ptp(motion.q, axis=0) > 0.3).all()


def test_friction_of_a_driven_arm_is_found(driven: Simulation) -> None:
    settings = AuditSettings(torque=TorqueSettings(drive="robot", robot="panda"))
    estimate = estimate_log(driven.log, settings)
    assert np.abs(coulomb(estimate) - COULOMB).max() < 0.03


def test_friction_of_a_guided_arm_is_found_with_default_settings() -> None:
    simulation = simulate(ArmSettings(duration_s=30.0), SEED)
    estimate = estimate_log(simulation.log, AuditSettings())
    assert np.abs(coulomb(estimate) - COULOMB)[1:].max() < 0.03
    truths = [
        (joint.coulomb, true.coulomb_nm) for joint, true in zip(estimate.friction.joints, PANDA_JOINTS, strict=True)
    ]
    assert sum(found.low <= truth <= found.high for found, truth in truths) >= 5
