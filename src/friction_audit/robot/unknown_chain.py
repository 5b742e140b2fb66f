"""Rigid-body torque of a chain of revolute joints without a model, identified from the log itself.

The torque of gravity is linear in cosine and sine of each angle, and a sine of the joint's own; that of inertia is
linear in accelerations and products of velocities, and of second degree in cosine and sine of each angle. Gaussian
processes with kernels of such functions hold every chain (A. Dalla Libera, R. Carli, IEEE Robotics and Automation
Letters 5 (2020) 24); their covariance at the samples by Cholesky decomposition with pivoting (H. Harbrecht, M. Peters,
R. Schneider, Appl. Numer. Math. 62 (2012) 428).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.joint_log import Float, Int

MOST = 300  # columns of a process: with 100 four clean joints of whole_arms 230000 that follow sines have a false name
ROUNDS = 10  # of expectation maximisation
ABSORBED = 1e-4  # of the norm of a column: less of it is rounding


class ChainMotion(NamedTuple):
    """Motion of all j joints of a chain at n samples, shape (n, j) each."""

    joint: int  # column of the joint that bears the torque
    cosine: Float  # of each position
    sine: Float
    dq: Float  # [rad/s]
    ddq: Float  # [rad/s^2]

    @classmethod
    def of(cls, joint: int, q: Float, dq: Float, ddq: Float) -> "ChainMotion":
        """Return the motion with these positions [rad]."""
        return cls(joint, np.cos(q), np.sin(q), dq, ddq)

    def at(self, which: Sequence[int] | Int | slice) -> "ChainMotion":
        """Return the motion at some of its samples."""
        return type(self)(self.joint, *(one[which] for one in self[1:]))


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


def _alike(motion: ChainMotion, pivots: ChainMotion, k: int) -> Float:
    """Cosine of the difference of an angle, shape (p, n)."""
    same: Float = pivots.cosine[:, [k]] * motion.cosine[:, k] + pivots.sine[:, [k]] * motion.sine[:, k]
    return same


def _of_gravity(motion: ChainMotion, pivots: ChainMotion) -> Float:
    out = _alike(motion, pivots, motion.joint)
    for other in (k for k in range(motion.dq.shape[1]) if k != motion.joint):
        out *= 0.5 + 0.5 * _alike(motion, pivots, other)
    return out


def _of_inertia(motion: ChainMotion, pivots: ChainMotion) -> Float:
    out = pivots.ddq @ motion.ddq.T + (pivots.dq @ motion.dq.T) ** 2
    for k in range(motion.dq.shape[1]):
        out *= (0.5 + 0.5 * _alike(motion, pivots, k)) ** 2
    return np.asarray(out)


def own_sines(motion: ChainMotion) -> Float:
    """Gravity of the load alone, an effect, shape (2, n)."""
    return np.stack([motion.cosine[:, motion.joint], motion.sine[:, motion.joint]])


def constant_coupling(motion: ChainMotion) -> Float:
    """Inertia that no angle changes, shape (2 j, n): the own one is nominal, that of the others an effect."""
    return np.vstack([motion.ddq.T, motion.dq.T**2])


GRAVITY = Process(_of_gravity, lambda motion: np.ones(len(motion.dq)), own_sines, 1e-9)
INERTIA = Process(
    _of_inertia,
    lambda motion: np.asarray(np.sum(motion.ddq**2, axis=1) + np.sum(motion.dq**2, axis=1) ** 2),
    constant_coupling,
    1e-7,
)
PROCESSES = (GRAVITY, INERTIA)


def decomposed(process: Process, motion: ChainMotion, most: int = MOST) -> Columns:
    """Columns of a process at samples of equal weight, without its effects."""
    # Row by row: the whole matrix, for LAPACK's dpstrf, has the square of some thousand samples.
    m, left = len(motion.dq), process.variance(motion)
    enough = process.least * max(float(left.mean()), 1e-300)
    rows, pivots = np.empty((most, m)), list[int]()
    while len(pivots) < most and left.mean() > enough:
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


def chain_columns(
    motion: ChainMotion, weight: Float, known: Float, y: Float, every: int = 1, most: int = MOST
) -> Float:
    """Columns of both processes, each of a standard normal coefficient in units of the noise, shape (k, m).

    Their variances and that of the noise by expectation maximisation (D. A. Harville, J. Am. Stat. Assoc. 72 (1977)
    320), given known columns, shape (b, m), and the effects that they leave out. The samples have some weight each;
    every so many of them are candidates for the Cholesky decomposition, for so many columns of a process at most.
    """
    thin = motion.at(slice(None, None, every))
    columns = [weight * decomposed(process, thin, most).at(motion) for process in PROCESSES]
    known = np.vstack([known, *(weight * process.effects(motion) for process in PROCESSES)])
    inside = np.linalg.qr((known / np.maximum(np.linalg.norm(known, axis=1), 1e-300)[:, None]).T)[0].T
    both, which = np.vstack(columns), np.repeat([0, 1], [len(one) for one in columns])
    free, left = (one - (one @ inside.T) @ inside for one in (both, y))
    noise = max(float(np.mean(left**2)), 1e-300)
    variances = noise / np.array([max(float(np.mean(np.sum(one**2, axis=0))), 1e-300) for one in columns])
    least, products, along = 1e-9 * variances, free @ free.T, free @ left
    for _ in range(ROUNDS):
        covariance = np.linalg.inv(products / noise + np.diag(1.0 / variances[which]))
        found = covariance @ along / noise
        noise = max(float(np.mean((left - found @ free) ** 2) + np.sum(covariance * products) / len(y)), 1e-300)
        power = np.bincount(which, found**2 + np.diag(covariance), 2) / np.maximum(np.bincount(which, minlength=2), 1)
        variances = np.maximum(power, least)
    return np.asarray(both * np.sqrt(variances[which] / noise)[:, None])


def free_of(basis: Float, rows: Float) -> Float:
    """Rows, shape (p, m), without what an orthonormal basis, shape (k, m), takes of them; zero where it takes all."""
    if not len(basis):
        return rows
    left = rows - (rows @ basis.T) @ basis
    left[np.sum(left**2, axis=1) <= ABSORBED**2 * np.sum(rows**2, axis=1)] = 0.0
    return np.asarray(left)
