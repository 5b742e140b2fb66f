"""Columns of the torque regressor of an arm: torque per unit of the inertial parameters of its links.

C. G. Atkeson, C. H. An, J. M. Hollerbach, Estimation of inertial parameters of manipulator loads and links,
International Journal of Robotics Research 5(3), 1986.
"""

from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.robot.arm import Arm, chunks

# Of a link, in its own frame: mass, first moments x, y, z, moments of inertia xx, xy, yy, xz, yz, zz.
PARAMETERS = 10
SEED = 0
POSES = 60
SIGNIFICANT = 1e-7  # of the largest column's square: what a column must add to those before it

Index = NDArray[np.int64]
Motion = tuple[Float, Float, Float]


def regressor_entries(arm: Arm, motion: Motion, joints: Index, links: Index, places: Index) -> Float:
    """Return entries of the regressor: joint's torque per unit of a parameter of a link, shape (n, e).

    Args:
        arm: The arm.
        motion: Position, velocity and acceleration, shape (n, j) each.
        joints: Column (of the log) of each entry's joint, shape (e,).
        links: Column (of the log) of the joint that carries each entry's link, shape (e,).
        places: Which of the ten parameters, shape (e,).
    """
    place = np.argsort(arm.columns)
    joints, links = place[joints], place[links]
    found = np.zeros((len(motion[0]), len(joints)))
    for rows in chunks(len(found)):
        poses = arm.poses(motion[0][rows])
        origin, orientation, axis = poses
        accelerations = _accelerations(arm, poses, motion[1][rows], motion[2][rows])
        for link in np.unique(links):
            local = (_rotated(orientation[:, link], part[:, link]) for part in accelerations)
            force, moment = _wrench(*local)
            for joint in _chain(arm, int(link)):
                entries = (links == link) & (joints == joint)
                if entries.any():
                    s = axis[:, joint]
                    across = np.cross(s, origin[:, link] - origin[:, joint])
                    pull, turn = (_rotated(orientation[:, link], side)[:, None] for side in (across, s))
                    found[rows, entries] = (pull @ force + turn @ moment)[:, 0, places[entries]]
    return found


def _accelerations(arm: Arm, poses: tuple[Float, Float, Float], dq: Float, ddq: Float) -> tuple[Float, Float, Float]:
    """Return of each link angular velocity and acceleration, and acceleration of its origin less gravity, (n, j, 3)."""
    origin, _, axis = poses
    spin, push = axis * arm.to_model(dq)[:, :, None], axis * arm.to_model(ddq)[:, :, None]
    turning, angular, linear = spin.copy(), push, np.tile(-arm.model.opt.gravity, (*dq.shape, 1))
    for link in range(dq.shape[1]):
        for parent in _chain(arm, link)[1:2]:
            before, lever = turning[:, parent], origin[:, link] - origin[:, parent]
            turning[:, link] += before
            angular[:, link] += angular[:, parent] + np.cross(before, spin[:, link])
            swing = np.cross(angular[:, parent], lever) + np.cross(before, np.cross(before, lever))
            linear[:, link] = linear[:, parent] + swing
    return turning, angular, linear


def _chain(arm: Arm, link: int) -> list[int]:
    """Return the joints of the model that move a link, from its own to the first."""
    model = arm.model
    joint_of = {int(body): joint for joint, body in enumerate(model.jnt_bodyid)}
    body, found = int(model.jnt_bodyid[link]), []
    while body > 0:
        if body in joint_of:
            found.append(joint_of[body])
        body = int(model.body_parentid[body])
    return found


def _wrench(turning: Float, angular: Float, linear: Float) -> tuple[Float, Float]:
    """Return force and moment about a link's origin per unit of its parameters, in its frame, shape (n, 3, 10) each.

    Atkeson, An and Hollerbach, equation (8); ``linear`` is the acceleration of the origin less gravity.
    """
    force, moment = np.zeros((2, len(linear), 3, PARAMETERS))
    force[:, :, 0] = linear
    force[:, :, 1:4] = _skew(angular) + _skew(turning) @ _skew(turning)
    moment[:, :, 1:4] = -_skew(linear)
    moment[:, :, 4:] = _inertia_columns(angular) + _skew(turning) @ _inertia_columns(turning)
    return force, moment


def _skew(v: Float) -> Float:
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def _inertia_columns(v: Float) -> Float:
    """Return what turns the six moments of inertia into inertia times v, shape (n, 3, 6)."""
    x, y, z = v.T
    zero = np.zeros_like(x)
    columns = [[x, y, zero, z, zero, zero], [zero, x, y, zero, z, zero], [zero, zero, zero, x, y, z]]
    return np.array(columns).transpose(2, 0, 1)


def _rotated(orientation: Float, v: Float) -> Float:
    """Express vectors of the base in the axes of a link, shape (n, 3)."""
    return (v[:, None] @ orientation)[:, 0]


def significant(columns: Float) -> NDArray[np.bool_]:
    """Return which columns, from first to last, are no combination of those before them, shape (p,)."""
    size = float(np.max(np.sum(columns**2, axis=0), initial=0.0))
    kept = np.zeros(columns.shape[1], bool)
    if size == 0.0:
        return kept
    for k, column in enumerate(columns.T):
        before = columns[:, kept]
        left = column - before @ np.linalg.lstsq(before, column)[0] if kept.any() else column
        kept[k] = left @ left > SIGNIFICANT * size
    return kept


def random_motion(joints: int, *, moving: bool) -> Motion:
    """Return random poses, with velocities and accelerations if moving, which show what can be identified at all."""
    rng = np.random.default_rng(SEED)
    q = rng.uniform(-np.pi, np.pi, (POSES, joints))
    dq, ddq = rng.normal(size=(2, POSES, joints)) * float(moving)
    return q, dq, ddq


def tilt_torque(arm: Arm, q: Float) -> Float:
    """Return the gravity torque per unit of gravity along two directions across the vertical, shape (n, j, 2)."""
    found = []
    for direction in np.linalg.svd(arm.model.opt.gravity[None])[2][1:]:
        model = copy(arm.model)
        model.opt.gravity[:] = direction
        found.append(replace(arm, model=model).gravity(q))
    return np.stack(found, axis=-1)
