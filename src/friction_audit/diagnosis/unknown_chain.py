"""Rigid-body torque of a chain of revolute joints whose model nobody gave, identified from the log itself.

The torque of gravity is linear in cosine and sine of each angle, and a sine of the joint's own; that of inertia is
linear in accelerations and products of velocities, and of second degree in cosine and sine of each angle. Gaussian
processes with kernels of such functions hold every chain (A. Dalla Libera, R. Carli, IEEE Robotics and Automation
Letters 5 (2020) 24); their covariance at the samples by Cholesky decomposition with pivoting (H. Harbrecht, M. Peters,
R. Schneider, Appl. Numer. Math. 62 (2012) 428).
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

MOST = 100  # columns of a process
# What a column must add of the variance: noise is a thousandth of gravity's torque, a hundredth of inertia's, or more.
LEAST_OF_GRAVITY, LEAST_OF_INERTIA = 1e-7, 1e-5
FITTED = 4000  # samples from which gravity is known well enough
ROUNDS = 10  # of expectation maximisation
ABSORBED = 1e-4  # of the norm of a column, what is rounding
AT_ONCE = 2**14  # samples, for memory


class ChainMotion(NamedTuple):
    """Motion of all j joints of a chain at n samples, shape (n, j) each, and which of them bears the torque."""

    joint: int
    q: Float  # [rad]
    dq: Float  # [rad/s]
    ddq: Float  # [rad/s^2]

    @classmethod
    def of(cls, data: JointData) -> "ChainMotion":
        """All joints on the fine grid of one."""
        return cls(data.own_column, data.others_q, data.others_dq, data.others_ddq)

    def each(self, change: Callable[[Float], Float]) -> "ChainMotion":
        """The motion at other samples."""
        return self._replace(q=change(self.q), dq=change(self.dq), ddq=change(self.ddq))


class Process(NamedTuple):
    """Columns, each of a normal coefficient of one variance: covariances with some samples, mixed."""

    kernel: Callable[[ChainMotion, ChainMotion], Float]
    effects: Callable[[ChainMotion], Float]  # torques that are effects or the nominal model, and are left out
    pivots: ChainMotion  # the samples, p of them
    mixing: Float  # shape (p, k)
    left_out: Float  # share of the effects, shape (e, k)

    def columns(self, motion: ChainMotion) -> Float:
        """Columns at samples, shape (k, n)."""
        covariance = self.kernel(motion, self.pivots)
        return np.asarray(self.mixing.T @ covariance - self.left_out.T @ self.effects(motion))


def gravity(motion: ChainMotion, pivots: ChainMotion) -> Float:
    """Covariance of gravity's torque, shape (p, n)."""
    out = np.cos(pivots.q[:, [motion.joint]] - motion.q[:, motion.joint])
    for other in (k for k in range(motion.q.shape[1]) if k != motion.joint):
        out *= 0.5 + 0.5 * np.cos(pivots.q[:, [other]] - motion.q[:, other])
    return np.asarray(out)


def inertia(motion: ChainMotion, pivots: ChainMotion) -> Float:
    """Covariance of the torque of inertia and of velocities, shape (p, n)."""
    out = pivots.ddq @ motion.ddq.T + (pivots.dq @ motion.dq.T) ** 2
    for k in range(motion.q.shape[1]):
        out *= (0.5 + 0.5 * np.cos(pivots.q[:, [k]] - motion.q[:, k])) ** 2
    return np.asarray(out)


def own_sines(motion: ChainMotion) -> Float:
    """Cosine and sine of the joint's own angle, shape (2, n)."""
    angle = motion.q[:, motion.joint]
    return np.stack([np.cos(angle), np.sin(angle)])


def constant_coupling(motion: ChainMotion) -> Float:
    """Accelerations and squared velocities of all joints, shape (2 j, n)."""
    return np.vstack([motion.ddq.T, motion.dq.T**2])


def decomposed(
    kernel: Callable[[ChainMotion, ChainMotion], Float],
    effects: Callable[[ChainMotion], Float],
    motion: ChainMotion,
    least: float,
) -> Process:
    """Decompose a covariance at samples; a column adds the least share of the mean variance or more."""
    m, left = len(motion.q), np.ones(len(motion.q))
    if kernel is inertia:
        left = np.sum(motion.ddq**2, axis=1) + np.sum(motion.dq**2, axis=1) ** 2
    enough = least * max(float(left.mean()), 1e-300)
    rows, pivots = np.empty((MOST, m)), list[int]()
    while len(pivots) < MOST and left.mean() > enough:
        k, pivot = len(pivots), int(np.argmax(left))
        row = kernel(motion, motion.each(lambda x, at=pivot: x[[at]]))[0] - rows[:k, pivot] @ rows[:k]
        rows[k] = row / np.sqrt(left[pivot])
        left = np.maximum(left - rows[k] ** 2, 0.0)
        pivots.append(pivot)
    rows, known = rows[: len(pivots)], effects(motion)
    shares = np.linalg.lstsq(known.T, rows.T)[0]
    turned, size, _ = np.linalg.svd(rows - shares.T @ known, full_matrices=False)
    turned = turned[:, size**2 > enough * m]
    mixing = np.linalg.solve(rows[:, pivots], turned)
    return Process(kernel, effects, motion.each(lambda x: x[pivots]), mixing, shares @ turned)


def chain_basis(data: JointData, weight: Float, seen: Callable[[Float], Float], X: Float, y: Float) -> Float:
    """What of the processes the log can tell from noise, orthonormal on the m samples, shape (k, m).

    Their variances and that of the noise by expectation maximisation (D. A. Harville, J. Am. Stat. Assoc. 72 (1977)
    320); a direction counts whose coefficient varies by more than noise makes of it.
    """
    motion = ChainMotion.of(data).each(lambda x: (seen(x) / weight).T)
    processes = [
        decomposed(gravity, own_sines, motion, LEAST_OF_GRAVITY),
        decomposed(inertia, constant_coupling, motion, LEAST_OF_INERTIA),
    ]
    columns = [weight * process.columns(motion) for process in processes]
    known = np.vstack([X, weight, *(weight * process.effects(motion) for process in processes)])
    inside = np.linalg.qr((known / np.maximum(np.linalg.norm(known, axis=1), 1e-300)[:, None]).T)[0].T
    free = np.vstack([one - (one @ inside.T) @ inside for one in columns])
    left = y - (y @ inside.T) @ inside
    which = np.repeat([0, 1], [len(one) for one in columns])
    usual = [max(float(np.mean(np.sum(one**2, axis=0))), 1e-300) for one in columns]
    noise = float(np.mean(left**2))
    variances, products, along = np.array([noise / one for one in usual]), free @ free.T, free @ left
    for _ in range(ROUNDS):
        covariance = np.linalg.inv(products / noise + np.diag(1.0 / variances[which]))
        c = covariance @ along / noise
        noise = max(float(np.mean((left - c @ free) ** 2) + np.sum(covariance * products) / len(y)), 1e-300)
        power = c**2 + np.diag(covariance)
        variances = np.array([max(float(np.mean(power[which == k])), 1e-300) if np.any(which == k) else 1.0 for k in (0, 1)])
    scaled = np.vstack(columns) * np.sqrt(variances[which])[:, None]
    _, size, basis = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(basis[size**2 > noise])


def free_of(basis: Float, rows: Float) -> Float:
    """Rows, shape (p, m), without what an orthonormal basis, shape (k, m), takes of them; zero where it takes all."""
    if not len(basis):
        return rows
    left = rows - (rows @ basis.T) @ basis
    left[np.sum(left**2, axis=1) <= ABSORBED**2 * np.sum(rows**2, axis=1)] = 0.0
    return np.asarray(left)


def with_gravity(data: JointData) -> JointData:
    """The joint with gravity as its load where the torque holds it and nothing tells how much, by least squares."""
    used = np.flatnonzero(data.used)
    if not data.weighs or data.load is not None or not len(used):
        return data
    some, motion = used[:: len(used) // FITTED + 1], ChainMotion.of(data)
    at = motion.each(lambda x: x[some])
    process, sines = decomposed(gravity, own_sines, at, LEAST_OF_GRAVITY), own_sines(at)
    of_chain = process.columns(at)
    friction = np.stack([data.direction, data.dq, np.ones(len(data.q))])[:, some]
    rows = np.vstack([sines, of_chain, friction, constant_coupling(at)])
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=1)), 1e-12)
    found = np.linalg.lstsq((rows / size[:, None]).T, data.torque[some], rcond=1e-9)[0] / size
    own, others = found[:2], found[2 : 2 + len(of_chain)]
    load = np.empty(len(data.q))
    for first in range(0, len(load), AT_ONCE):
        part = motion.each(lambda x, first=first: x[first : first + AT_ONCE])
        load[first : first + AT_ONCE] = own @ own_sines(part) + others @ process.columns(part)
    return replace(data, load=load)
