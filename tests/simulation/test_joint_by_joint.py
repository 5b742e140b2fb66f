"""One compensator for each joint of an arm."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.compensation.compensators import FixedCompensation
from friction_audit.errors import UsageError
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import JointByJoint, of_each_joint

ONE = FixedCompensation(coulomb_nm=0.2, viscous_nms_per_rad=0.03)
SHORT = ArmSettings(duration_s=2.0)


def test_every_joint_has_its_own() -> None:
    own = tuple(replace(ONE, coulomb_nm=0.0, viscous_nms_per_rad=0.01 * joint) for joint in range(7))
    motion = simulate(replace(SHORT, compensator=JointByJoint(compensators=own)), 0).truth.motion
    largest = np.abs(motion.compensation_nm).max(axis=0)
    assert largest[0] == 0.0
    assert (largest[1:] > 0.0).all()


def test_as_many_as_joints() -> None:
    with pytest.raises(UsageError, match="2 compensators: expected 7"):
        of_each_joint(JointByJoint(compensators=(ONE, ONE)), 7)
    assert of_each_joint(None, 2) == (None, None)
