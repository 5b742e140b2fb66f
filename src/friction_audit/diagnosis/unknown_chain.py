"""Rigid-body torque of a chain of revolute joints whose model nobody gave, identified from the log itself.

The torque of gravity is linear in cosine and sine of each angle, and a sine of the joint's own; that of inertia is
linear in accelerations and products of velocities, and of second degree in cosine and sine of each angle. Gaussian
processes with kernels of such functions hold every chain (A. Dalla Libera, R. Carli, IEEE Robotics and Automation
Letters 5 (2020) 24); their covariance at the samples by Cholesky decomposition with pivoting (H. Harbrecht, M. Peters,
R. Schneider, Appl. Numer. Math. 62 (2012) 428).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.samples import Index
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

MOST = 100  # columns of a process
MOST_PER_SAMPLE = 0.25  # of both: friction needs samples too
ROUNDS = 10  # of expectation maximisation
ABSORBED = 1e-4  # of the norm of a column: less of it is rounding
FITTED = 4000  # samples from which gravity is known well enough
NOISE = 1e-6  # variance of noise over that of gravity's coefficients
AT_ONCE = 2**14  # samples, for memory


class ChainMotion(NamedTuple):
    """Motion of all j joints of a chain at n samples, shape (n, j) each."""

    joint: int  # column of the joint that bears the torque
    q: Float  # [rad]
    dq: Float  # [rad/s]
    ddq: Float  # [rad/s^2]

    def each(self, change: Callable[[Float], Float]) -> "ChainMotion":
        """The motion as something else sees it."""
        return self._replace(q=change(self.q), dq=change(self.dq), ddq=change(self.ddq))

    def at(self, which: Sequence[int] | Index | slice) -> "ChainMotion":
        """The motion at some of its samples."""
        return self._replace(q=self.q[which], dq=self.dq[which], ddq=self.ddq[which])


class Process(NamedTuple):
    """A Gaussian process of the torque."""

    covariance: Callable[[ChainMotion, ChainMotion], Float]  # of n samples with p others, shape (p, n)
    variance: Callable[[ChainMotion], Float]  # of each sample, shape (n,)
    effects: Callable[[ChainMotion], Float]  # torques that are effects or the nominal model, left out, shape (e, n)
    least: float  # what a column must add of the mean variance: noise is no smaller


class Columns(NamedTuple):
    """Columns of a process, each of a normal coefficient of one variance: covariances with some samples, mixed."""

    process: Process
    pivots: ChainMotion  # the samples, p of them
    mixing: Float  # shape (p, k)
    left_out: Float  # share of the effects, shape (e, k)

    def at(self, motion: ChainMotion) -> Float:
        """The columns at samples, shape (k, n)."""
        covariance = self.process.covariance(motion, self.pivots)
        return np.asarray(self.mixing.T @ covariance - self.left_out.T @ self.process.effects(motion))


def _of_gravity(motion: ChainMotion, pivots: ChainMotion) -> Float:
    out = np.cos(pivots.q[:, [motion.joint]] - motion.q[:, motion.joint])
    for other in (k for k in range(motion.q.shape[1]) if k != motion.joint):
        out *= 0.5 + 0.5 * np.cos(pivots.q[:, [other]] - motion.q[:, other])
    return np.asarray(out)


def _of_inertia(motion: ChainMotion, pivots: ChainMotion) -> Float:
    out = pivots.ddq @ motion.ddq.T + (pivots.dq @ motion.dq.T) ** 2
    for k in range(motion.q.shape[1]):
        out *= (0.5 + 0.5 * np.cos(pivots.q[:, [k]] - motion.q[:, k])) ** 2
    return np.asarray(out)


def _own_sines(motion: ChainMotion) -> Float:
    angle = motion.q[:, motion.joint]
    return np.stack([np.cos(angle), np.sin(angle)])


def _constant_coupling(motion: ChainMotion) -> Float:
    return np.vstack([motion.ddq.T, motion.dq.T**2])


GRAVITY = Process(_of_gravity, lambda motion: np.ones(len(motion.q)), _own_sines, 1e-7)
INERTIA = Process(
    _of_inertia,
    lambda motion: np.asarray(np.sum(motion.ddq**2, axis=1) + np.sum(motion.dq**2, axis=1) ** 2),
    _constant_coupling,
    1e-5,
)


def _decomposed(process: Process, motion: ChainMotion) -> Columns:
    # Row by row: the whole matrix, for LAPACK's dpstrf, has the square of some thousand samples.
    m, left = len(motion.q), process.variance(motion)
    enough = process.least * max(float(left.mean()), 1e-300)
    rows, pivots = np.empty((MOST, m)), list[int]()
    while len(pivots) < MOST and left.mean() > enough:
        k, pivot = len(pivots), int(np.argmax(left))
        row = process.covariance(motion, motion.at([pivot]))[0] - rows[:k, pivot] @ rows[:k]
        rows[k] = row / np.sqrt(left[pivot])
        left = np.maximum(left - rows[k] ** 2, 0.0)
        pivots.append(pivot)
    rows, known = rows[: len(pivots)], process.effects(motion)
    shares = np.linalg.lstsq(known.T, rows.T)[0]
    turned, size, _ = np.linalg.svd(rows - shares.T @ known, full_matrices=False)
    turned = turned[:, size**2 > enough * m]
    mixing = np.linalg.solve(rows[:, pivots], turned)
    return Columns(process, motion.at(pivots), mixing, shares @ turned)


def chain_basis(data: JointData, weight: Float, seen: Callable[[Float], Float], X: Float, y: Float) -> Float:
    """What of both processes the log can tell from noise, orthonormal on the m samples, shape (k, m).

    Their variances and that of the noise by expectation maximisation (D. A. Harville, J. Am. Stat. Assoc. 72 (1977)
    320), beside nominal columns, shape (b, m), and the effects that they leave out; a direction counts whose
    coefficient varies by more than noise makes of it. ``seen`` brings the fine grid, shape (n, j), to the samples,
    shape (j, m), of some weight each.
    """
    motion = _chain_of(data).each(lambda x: (seen(x) / weight).T)
    columns = [weight * _decomposed(process, motion).at(motion) for process in (GRAVITY, INERTIA)]
    known = np.vstack([X, weight, *(weight * process.effects(motion) for process in (GRAVITY, INERTIA))])
    inside = np.linalg.qr((known / np.maximum(np.linalg.norm(known, axis=1), 1e-300)[:, None]).T)[0].T
    both, which = np.vstack(columns), np.repeat([0, 1], [len(one) for one in columns])
    free, left = both - (both @ inside.T) @ inside, y - (y @ inside.T) @ inside
    noise = max(float(np.mean(left**2)), 1e-300)
    variances = noise / np.array([max(float(np.mean(np.sum(one**2, axis=0))), 1e-300) for one in columns])
    least, products, along = 1e-9 * variances, free @ free.T, free @ left
    for _ in range(ROUNDS):
        covariance = np.linalg.inv(products / noise + np.diag(1.0 / variances[which]))
        found = covariance @ along / noise
        noise = max(float(np.mean((left - found @ free) ** 2) + np.sum(covariance * products) / len(y)), 1e-300)
        power = np.bincount(which, found**2 + np.diag(covariance), 2) / np.maximum(np.bincount(which, minlength=2), 1)
        variances = np.maximum(power, least)
    _, size, basis = np.linalg.svd(both * np.sqrt(variances[which])[:, None], full_matrices=False)
    return np.asarray(basis[size**2 > noise][: int(MOST_PER_SAMPLE * len(y))])


def left_to_effects(data: JointData) -> Float:
    """What of an unknown chain's torque is an effect of its own, on the fine grid, shape (n, e)."""
    motion = _chain_of(data)
    return np.vstack([process.effects(motion) for process in (GRAVITY, INERTIA)]).T


def free_of(basis: Float, rows: Float) -> Float:
    """Rows, shape (p, m), without what an orthonormal basis, shape (k, m), takes of them; zero where it takes all."""
    if not len(basis):
        return rows
    left = rows - (rows @ basis.T) @ basis
    left[np.sum(left**2, axis=1) <= ABSORBED**2 * np.sum(rows**2, axis=1)] = 0.0
    return np.asarray(left)


def with_gravity(data: JointData) -> JointData:
    """The joint with gravity as its load where the torque holds it and nothing says how much, by ridge regression.

    Without a constant: a sine of a narrow range of angles and a constant of the opposite sign are nearly nothing.
    """
    used = np.flatnonzero(data.used)
    if not data.weighs or data.load is not None or not len(used):
        return data
    some, motion = used[:: len(used) // FITTED + 1], _chain_of(data)
    at = motion.at(some)
    chain, sines = _decomposed(GRAVITY, at), _own_sines(at)
    of_chain = chain.at(at)
    weighing = np.vstack([sines, of_chain])
    rows = np.vstack([weighing, np.stack([data.direction, data.dq])[:, some], _constant_coupling(at)])
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=1)), 1e-12)
    prior = np.zeros((len(weighing), len(rows)))
    np.fill_diagonal(prior, np.sqrt(NOISE * len(some)))
    known = np.append(data.torque[some], np.zeros(len(weighing)))
    found = np.linalg.lstsq(np.vstack([rows.T, prior]) / size, known, rcond=1e-9)[0] / size
    own, others = np.split(found[: len(weighing)], [2])
    load = np.empty(len(data.q))
    for first in range(0, len(load), AT_ONCE):
        part = motion.at(slice(first, first + AT_ONCE))
        load[first : first + AT_ONCE] = own @ _own_sines(part) + others @ chain.at(part)
    return replace(data, load=load)


def _chain_of(data: JointData) -> ChainMotion:
    return ChainMotion(data.own_column, data.others_q, data.others_dq, data.others_ddq)
