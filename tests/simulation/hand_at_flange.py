"""The hand's spring and damper at the flange of an arm, written once more, from poses and the intended path."""

from typing import NamedTuple

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from friction_audit.joint_log import Float
from friction_audit.robot import Arm, load_arm
from friction_audit.simulation import ArmSettings, TrueMotion
from friction_audit.simulation.settings import make_streams
from friction_audit.simulation.strokes import HandMotion, plan_hand


class Pull(NamedTuple):
    """What the hand does; n ticks."""

    torque_nm: Float  # torque at the joints, shape (n, 7) [N m]
    power_w: Float  # power into the arm and the hand's own mass, shape (n,) [W]


def intended(settings: ArmSettings, seed: int, ticks: int) -> HandMotion:
    return plan_hand(settings.hand.path, ticks, 1e-3, make_streams(seed, 7).person)


def flange_poses(arm: Arm, q: Float) -> tuple[Float, Float, Float]:
    """Return places of the flange, shape (n, 3), orientations, shape (n, 3, 3), and Jacobians, shape (n, 6, j)."""
    data = mujoco.MjData(arm.model)
    flange = arm.model.body(arm.flange).id
    place, turned, jacobian = np.empty((len(q), 3)), np.empty((len(q), 3, 3)), np.empty((len(q), 6, q.shape[1]))
    for k, data.qpos[:] in enumerate(q):
        mujoco.mj_kinematics(arm.model, data)
        mujoco.mj_comPos(arm.model, data)
        mujoco.mj_jacBody(arm.model, data, jacobian[k, :3], jacobian[k, 3:], flange)
        place[k], turned[k] = data.xpos[flange], data.xmat[flange].reshape(3, 3)
    return place, turned, jacobian


def pull(settings: ArmSettings, seed: int, motion: TrueMotion) -> Pull:
    arm, hand = load_arm(), settings.hand
    path = intended(settings, seed, len(motion.t) - 1)
    n = len(motion.q)
    flange, turned, jacobian = flange_poses(arm, motion.q)
    place, upright = flange[0], Rotation.from_matrix(turned[0])
    twist = np.einsum("kij,kj->ki", jacobian, motion.dq)
    off = place + path.position[:n] - flange
    # All rotations at a time: one by one they would take most of the time of the tests.
    turn = Rotation.from_rotvec(path.rotation[:n]) * upright * Rotation.from_matrix(turned).inv()
    force = hand.stiffness_n_per_m * off + hand.damping_ns_per_m * (path.velocity[:n] - twist[:, :3])
    force[:, 2] += hand.mass_kg * 9.81
    moment = hand.turning_stiffness_nm_per_rad * turn.as_rotvec()
    moment += hand.turning_damping_nms_per_rad * (path.angular[:n] - twist[:, 3:])
    wrench = np.hstack((force, moment))
    torque, power = np.einsum("kij,ki->kj", jacobian, wrench), np.sum(wrench * twist, axis=1)
    return Pull(torque, power)
