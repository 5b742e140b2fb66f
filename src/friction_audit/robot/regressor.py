"""Columns of the torque regressor of an arm: torque per unit of the inertial parameters of its links.

C. G. Atkeson, C. H. An, J. M. Hollerbach, Estimation of inertial parameters of manipulator loads and links,
International Journal of Robotics Research 5(3), 1986.
"""

from functools import partial

import numpy as np

from friction_audit.joint_log import Bool, Float, Int
from friction_audit.robot.arm import Arm

# Of a link, in its own frame: mass, first moments x, y, z, moments of inertia xx, xy, yy, xz, yz, zz.
PARAMETERS, MOMENTS = 10, 3  # and the last first moment
SEED = 0
POSES = 60
SIGNIFICANT = 1e-7  # squared residual of an independent column, over the largest squared norm

Motion = tuple[Float, Float, Float]
# Vectors (3, n) times matrices (3, k, n), shape (k, n).
_times = partial(np.einsum, "in,ikn->kn")


def regressor_entries(arm: Arm, motion: Motion, joints: Int, links: Int, places: Int) -> Float:
    """Return entries of the regressor: a joint's torque per unit of one of the ten parameters of a link, shape (n, e).

    For each entry, shape (e,): the log's column of its joint, that of the joint that carries its link, the parameter.
    """
    place = np.argsort(arm.columns)
    joints, links = place[joints], place[links]
    found = np.zeros((len(joints), len(motion[0])))
    origin, orientation, axis = arm.poses(motion[0])
    accelerations = _accelerations(arm, origin, axis, arm.to_model(motion[1]), arm.to_model(motion[2]))
    for link in np.unique(links):
        highest = int(places[links == link].max())
        force, moment = _wrench(*(_times(part[link], orientation[link]) for part in accelerations), highest=highest)
        for joint in _joints_to_base(arm, int(link)):
            entries = np.flatnonzero((links == link) & (joints == joint))
            if len(entries):
                across = np.cross(axis[joint], origin[link] - origin[joint], axis=0)
                pull, turn = (_times(side, orientation[link]) for side in (across, axis[joint]))
                own = places[entries]
                found[entries] = _times(pull, force[:, own]) + _times(turn, moment[:, own])
    return found.T


def _accelerations(arm: Arm, origin: Float, axis: Float, dq: Float, ddq: Float) -> tuple[Float, Float, Float]:
    """Return angular velocity and acceleration of each link, and its origin's acceleration less gravity, (j, 3, n)."""
    spin, push = axis * dq.T[:, None], axis * ddq.T[:, None]
    turning, angular = spin.copy(), push
    linear = np.repeat(np.tile(-arm.model.opt.gravity, (len(axis), 1))[:, :, None], len(dq), axis=2)
    for link in range(len(axis)):
        for parent in _joints_to_base(arm, link)[1:2]:
            before, lever = turning[parent], origin[link] - origin[parent]
            turning[link] += before
            angular[link] += angular[parent] + np.cross(before, spin[link], axis=0)
            pull = np.cross(angular[parent], lever, axis=0) + np.cross(before, np.cross(before, lever, axis=0), axis=0)
            linear[link] = linear[parent] + pull
    return turning, angular, linear


def _joints_to_base(arm: Arm, link: int) -> list[int]:
    """Return the joints of the model that move a link, from its own to the first."""
    found = []
    while link >= 0:
        found.append(link)
        link = int(arm.model.dof_parentid[link])
    return found


def _wrench(turning: Float, angular: Float, linear: Float, *, highest: int) -> tuple[Float, Float]:
    """Return force and moment about a link's origin per unit of its parameters, in its frame, shape (3, 10, n) each.

    Those of the moments of inertia are computed only if ``highest`` is one of them. Atkeson, An and Hollerbach,
    equation (8); ``linear`` is the acceleration of the origin less gravity.
    """
    force, moment = np.zeros((2, 3, PARAMETERS, linear.shape[1]))
    spin = _skew(turning)
    force[:, 0] = linear
    force[:, 1:4] = _skew(angular) + np.einsum("ijn,jkn->ikn", spin, spin)
    moment[:, 1:4] = -_skew(linear)
    if highest > MOMENTS:
        moment[:, 4:] = _inertia_columns(angular) + np.einsum("ijn,jkn->ikn", spin, _inertia_columns(turning))
    return force, moment


def _skew(v: Float) -> Float:
    x, y, z = v
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def _inertia_columns(v: Float) -> Float:
    """Return the matrix that multiplies the six moments of inertia to inertia times v, shape (3, 6, n)."""
    x, y, z = v
    zero = np.zeros_like(x)
    return np.array([[x, y, zero, z, zero, zero], [zero, x, y, zero, z, zero], [zero, zero, zero, x, y, z]])


def significant(columns: Float) -> Bool:
    """Return which columns are linearly independent of those before them, shape (p,)."""
    size = float(np.max(np.sum(columns**2, axis=0), initial=0.0))
    kept = np.zeros(columns.shape[1], bool)
    for k, column in enumerate(columns.T):
        before = columns[:, kept]
        left = column - before @ np.linalg.lstsq(before, column)[0] if kept.any() else column
        kept[k] = left @ left > SIGNIFICANT * size
    return kept


def random_motion(joints: int, *, moving: bool) -> Motion:
    """Return random poses, with velocities and accelerations if moving, to find the identifiable parameters."""
    rng = np.random.default_rng(SEED)
    q = rng.uniform(-np.pi, np.pi, (POSES, joints))
    dq, ddq = rng.normal(size=(2, POSES, joints)) * float(moving)
    return q, dq, ddq


def tilt_torque(arm: Arm, q: Float) -> Float:
    """Return the gravity torque per unit of gravity along two horizontal directions, shape (n, j, 2)."""
    across = np.linalg.svd(arm.model.opt.gravity[None])[2][1:]
    return np.stack([arm.with_gravity(one).gravity(q) for one in across], axis=-1)
