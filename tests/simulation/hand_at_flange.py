"""The hand's spring and damper at the flange of an arm, written once more, from poses and the intended path."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from friction_audit.joint_log import Float
from friction_audit.robot import load_arm
from friction_audit.simulation import ArmSettings, Motion
from friction_audit.simulation.clock import make_streams
from friction_audit.simulation.motion import plan_hand
from friction_audit.simulation.motion.hand_path import HandMotion


@dataclass(frozen=True, eq=False, kw_only=True)
class Pull:
    """What the hand does; n ticks.

    Attributes:
        torque_nm: Torque at the joints, shape (n, 7). [N m]
        power_w: Power into the arm and the hand's own mass, shape (n,). [W]
        off_m: Distance of the flange from the intended place, shape (n,). [m]
        turned_rad: Angle between intended and actual orientation, shape (n,). [rad]
    """

    torque_nm: Float
    power_w: Float
    off_m: Float
    turned_rad: Float


def intended(settings: ArmSettings, seed: int, ticks: int) -> HandMotion:
    """Return the path that the hand means to take."""
    return plan_hand(settings.hand.path, ticks, 1e-3, make_streams(seed, 7).person)


def pull(settings: ArmSettings, seed: int, motion: Motion) -> Pull:
    """Return what the hand does along a motion."""
    arm, hand = load_arm(), settings.hand
    model, data = arm.model, arm.model.createData()
    frame = model.getFrameId(arm.flange)
    path = intended(settings, seed, len(motion.t) - 1)
    pin.framesForwardKinematics(model, data, motion.q[0])
    place, upright = data.oMf[frame].translation.copy(), Rotation.from_matrix(data.oMf[frame].rotation)
    n = len(motion.q)
    jacobian, flange, turned = np.empty((n, 6, 7)), np.empty((n, 3)), np.empty((n, 3, 3))
    for k, q in enumerate(motion.q):
        jacobian[k] = pin.computeFrameJacobian(model, data, q, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        flange[k], turned[k] = data.oMf[frame].translation, data.oMf[frame].rotation
    twist = np.einsum("kij,kj->ki", jacobian, motion.dq)
    off = place + path.position[:n] - flange
    # All rotations at a time: one by one they would take most of the time of the tests.
    turn = Rotation.from_rotvec(path.rotation[:n]) * upright * Rotation.from_matrix(turned).inv()
    force = hand.stiffness_n_per_m * off + hand.damping_ns_per_m * (path.velocity[:n] - twist[:, :3])
    force[:, 2] += hand.mass_kg * 9.81
    moment = hand.turning_stiffness_nm_per_rad * turn.as_rotvec()
    moment += hand.turning_damping_nms_per_rad * (path.angular[:n] - twist[:, 3:])
    wrench = np.hstack((force, moment))
    return Pull(
        torque_nm=np.einsum("kij,ki->kj", jacobian, wrench),
        power_w=np.sum(wrench * twist, axis=1),
        off_m=np.linalg.norm(off, axis=1),
        turned_rad=np.asarray(turn.magnitude()),
    )
