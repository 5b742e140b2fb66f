"""Gravity in the torque of a joint as all joints of an unknown chain change it, identified from the log itself.

The potential energy of a chain of revolute joints is linear in the cosine and the sine of each angle, so that the
torque of gravity is a sine of the joint's own angle with factors that the others change. A Gaussian process with the
kernel of such functions holds every chain (A. Dalla Libera, R. Carli, IEEE Robotics and Automation Letters 5 (2020)
24, of degree one); its covariance at the samples by Cholesky decomposition with pivoting (H. Harbrecht, M. Peters, R.
Schneider, Appl. Numer. Math. 62 (2012) 428).
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

MOST = 100  # columns
LEAST = 1e-7  # of the variance of gravity, what a column must add: noise is a thousandth of gravity's torque or more
FITTED = 4000  # samples
AT_ONCE = 16  # columns on the fine grid, for memory


class ChainGravity(NamedTuple):
    """Columns, each of a normal coefficient of one variance: covariances with positions, mixed, less own sines."""

    joint: int  # column of the joint among all
    pivots: Float  # positions of all joints, shape (p, j) [rad]
    mixing: Float  # shape (p, k)
    own: Float  # share of the cosine and the sine of the joint's own angle, which are an effect, shape (2, k)

    @classmethod
    def of(cls, q: Float, joint: int) -> "ChainGravity":
        """Decompose the covariance at the positions of the samples, shape (m, j). [rad]"""
        left, rows, pivots = np.ones(len(q)), np.empty((MOST, len(q))), list[int]()
        while len(pivots) < MOST and left.mean() > LEAST:
            k, pivot = len(pivots), int(np.argmax(left))
            row = _alike(q, q[[pivot]], joint)[0] - rows[:k, pivot] @ rows[:k]
            rows[k] = row / np.sqrt(left[pivot])
            left = np.maximum(left - rows[k] ** 2, 0.0)
            pivots.append(pivot)
        rows, sines = rows[: len(pivots)], _sines(q[:, joint])
        own = np.linalg.lstsq(sines, rows.T)[0]
        turned, size, _ = np.linalg.svd(rows - (sines @ own).T, full_matrices=False)
        turned = turned[:, size**2 > LEAST * len(q)]
        return cls(joint, q[pivots], np.linalg.solve(rows[:, pivots], turned), own @ turned)

    def columns(self, q: Float, seen: Callable[[Float], Float]) -> Float:
        """Columns at positions of all joints, shape (n, j), as the samples see them, (n, p) as (p, m); shape (k, m)."""
        alike = np.vstack([seen(_alike(q, some, self.joint).T) for some in self._parts])
        return np.asarray(self.mixing.T @ alike - self.own.T @ seen(_sines(q[:, self.joint])))

    def torque(self, q: Float, coefficients: Float) -> Float:
        """The torque of coefficients, shape (k,), at positions of all joints, shape (n, j); shape (n,). [N m]"""
        weights = np.array_split(self.mixing @ coefficients, len(self._parts))
        torque = sum(own @ _alike(q, some, self.joint) for own, some in zip(weights, self._parts, strict=True))
        return np.asarray(torque - _sines(q[:, self.joint]) @ (self.own @ coefficients))

    @property
    def _parts(self) -> list[Float]:
        return np.array_split(self.pivots, len(self.pivots) // AT_ONCE + 1)


def with_gravity(data: JointData) -> JointData:
    """The joint with gravity as its load where the torque holds it and nothing tells how much, by least squares."""
    used = np.flatnonzero(data.used)
    if not data.weighs or data.load is not None or not len(used):
        return data
    some = used[:: len(used) // FITTED + 1]
    chain = ChainGravity.of(data.others_q[some], data.own_column)
    of_chain, sines = chain.columns(data.others_q[some], np.transpose), _sines(data.q)
    friction = np.column_stack([data.direction, data.dq, data.ddq, np.ones(len(data.q))])[some]
    rows = np.column_stack([friction, sines[some], of_chain.T])
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=0)), 1e-12)
    found = np.linalg.lstsq(rows / size, data.torque[some], rcond=1e-9)[0] / size
    return replace(data, load=sines @ found[4:6] + chain.torque(data.others_q, found[6:]))


def _alike(q: Float, pivots: Float, joint: int) -> Float:
    """Covariance of gravity at positions, shape (n, j), with that at others, (p, j): shape (p, n)."""
    out = np.cos(pivots[:, [joint]] - q[:, joint])
    for other in (k for k in range(q.shape[1]) if k != joint):
        out *= 0.5 + 0.5 * np.cos(pivots[:, [other]] - q[:, other])
    return np.asarray(out)


def _sines(angle: Float) -> Float:
    return np.column_stack([np.cos(angle), np.sin(angle)])
