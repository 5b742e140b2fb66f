"""Columns of the torque regressor of an arm: torque per unit of the inertial parameters of its links.

C. G. Atkeson, C. H. An, J. M. Hollerbach, Estimation of inertial parameters of manipulator loads and links,
International Journal of Robotics Research 5(3), 1986.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.robot.arm import Arm

PARAMETERS = 10
"""Of a link, in Pinocchio's order: mass, first moments x, y, z, moments of inertia xx, xy, yy, xz, yz, zz."""
SEED = 0
POSES = 60
NO_NEWS = 1e-7
"""Of the largest column's square: what a column must add to those before it."""

Index = NDArray[np.int64]


def regressor_entries(
    arm: Arm, motion: tuple[Float, Float, Float], joints: Index, links: Index, places: Index
) -> Float:
    """Return entries of the regressor: joint's torque per unit of a parameter of a link, shape (n, e).

    Args:
        arm: The arm.
        motion: Position, velocity and acceleration, shape (n, j) each.
        joints: Column (of the log) of each entry's joint, shape (e,).
        links: Column (of the log) of the joint that carries each entry's link, shape (e,).
        places: Which of the ten parameters, shape (e,).
    """
    import pinocchio as pin

    order = list(arm.columns)
    place = np.argsort(order)
    rows, columns = place[joints], PARAMETERS * place[links] + places
    data = arm.model.createData()
    found = np.empty((len(motion[0]), len(joints)))
    arranged = (np.ascontiguousarray(signal[:, order]) for signal in motion)
    for k, (q, dq, ddq) in enumerate(zip(*arranged, strict=True)):
        found[k] = pin.computeJointTorqueRegressor(arm.model, data, q, dq, ddq)[rows, columns]
    return found


def news(columns: Float) -> NDArray[np.bool_]:
    """Tell which columns, from first to last, are no combination of those before them, shape (p,)."""
    size = float(np.max(np.sum(columns**2, axis=0), initial=0.0))
    kept = np.zeros(columns.shape[1], bool)
    if size == 0.0:
        return kept
    for k, column in enumerate(columns.T):
        before = columns[:, kept]
        left = column - before @ np.linalg.lstsq(before, column)[0] if kept.any() else column
        kept[k] = left @ left > NO_NEWS * size
    return kept


def random_motion(joints: int, *, moving: bool) -> tuple[Float, Float, Float]:
    """Return poses anywhere, and speeds and accelerations if moving: what can be told of an arm at all."""
    rng = np.random.default_rng(SEED)
    q = rng.uniform(-np.pi, np.pi, (POSES, joints))
    dq, ddq = rng.normal(size=(2, POSES, joints)) * float(moving)
    return q, dq, ddq


def tilt_torque(arm: Arm, q: Float) -> Float:
    """Return the gravity torque per unit of gravity along two directions across the vertical, shape (n, j, 2)."""
    import pinocchio as pin

    order, across = list(arm.columns), np.linalg.svd(arm.model.gravity.linear[None])[2][1:]
    arranged = np.ascontiguousarray(q[:, order])
    found = np.empty((*q.shape, 2))
    for k, direction in enumerate(across):
        model = arm.model.copy()
        model.gravity.linear = direction
        data = model.createData()
        found[:, order, k] = np.stack([pin.computeGeneralizedGravity(model, data, row) for row in arranged])
    return found
