"""Inertia that each joint moves with though a rigid-body model has taken its torque out of the recorded one."""

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.robot import Arm

POSES = 50
"""Of a recording, evenly spread."""


def known_inertias(arm: Arm | None, choice: TorqueChoice, q: Float) -> Float:
    """Return the mean diagonal of the mass matrix along a motion, zero where no model took it, shape (j,). [kg m^2]

    Args:
        arm: The model of the arm, or None.
        choice: How the interaction torque was made.
        q: Positions of all joints, shape (n, j). [rad]
    """
    joints = q.shape[1]
    if arm is None or choice.inertia != "model":
        return np.zeros(joints)
    poses = q[:: max(len(q) // POSES, 1)]
    still, weight = np.zeros_like(poses), arm.gravity(poses)
    units = np.eye(joints)
    own = [arm.inverse_dynamics(poses, still, still + units[k])[:, k] - weight[:, k] for k in range(joints)]
    return np.asarray(np.mean(own, axis=1))
