"""Rigid-body torque of a chain of revolute joints without a model, as Gaussian processes that are fitted to the log.

The torque of gravity is linear in cosine and sine of each angle, and a sine of the joint's own angle; that of inertia
is linear in accelerations and products of velocities, and of second degree in cosine and sine of each angle. Gaussian
processes with kernels of such functions contain every chain (A. Dalla Libera, R. Carli, IEEE Robot. Autom. Lett. 5
(2020) 24); their covariance at samples by pivoted Cholesky decomposition (H. Harbrecht, M. Peters, R. Schneider, Appl.
Numer. Math. 62 (2012) 428).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.joint_log import Float, Int

MOST_COLUMNS = (
    300  # columns of a process; with 100, four joints of whole_arms 230000 without effects get a false effect
)
EM_ITERATIONS = 10  # iterations of expectation maximisation
ROUNDING_SHARE = 1e-4  # share of a column's norm below which the rest is rounding


class ChainMotion(NamedTuple):
    """Motion of all j joints of a chain at n samples, shape (n, j) each."""

    joint: int  # column of the joint whose torque is modelled
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
    effects: Callable[[ChainMotion], Float]  # columns of effects and of the nominal model, excluded, shape (e, n)
    least: float  # share of the mean variance that a column must add; noise is larger


class Columns(NamedTuple):
    """Columns of a process, whose coefficients are independent normal variables of one variance (Nystroem basis)."""

    process: Process
    pivots: ChainMotion  # p samples of the decomposition
    mixing: Float  # shape (p, k)
    effect_share: Float  # multiples of the effects that are subtracted, shape (e, k)

    def at(self, motion: ChainMotion) -> Float:
        """Return the columns at samples, shape (k, n)."""
        covariance = self.process.covariance(motion, self.pivots)
        return np.asarray(self.mixing.T @ covariance - self.effect_share.T @ self.process.effects(motion))


def _cosine_of_difference(motion: ChainMotion, pivots: ChainMotion, k: int) -> Float:
    """Return the cosine of the difference of an angle, shape (p, n)."""
    same: Float = pivots.cosine[:, [k]] * motion.cosine[:, k] + pivots.sine[:, [k]] * motion.sine[:, k]
    return same


def _gravity_kernel(motion: ChainMotion, pivots: ChainMotion) -> Float:
    out = _cosine_of_difference(motion, pivots, motion.joint)
    for other in (k for k in range(motion.dq.shape[1]) if k != motion.joint):
        out *= 0.5 + 0.5 * _cosine_of_difference(motion, pivots, other)
    return out


def _inertia_kernel(motion: ChainMotion, pivots: ChainMotion) -> Float:
    out = pivots.ddq @ motion.ddq.T + (pivots.dq @ motion.dq.T) ** 2
    for k in range(motion.dq.shape[1]):
        out *= (0.5 + 0.5 * _cosine_of_difference(motion, pivots, k)) ** 2
    return np.asarray(out)


def own_gravity(motion: ChainMotion) -> Float:
    """Return the columns of gravity that depend on the joint's own angle alone, an effect, shape (2, n)."""
    return np.stack([motion.cosine[:, motion.joint], motion.sine[:, motion.joint]])


def constant_coupling(motion: ChainMotion) -> Float:
    """Return columns of constant inertia, shape (2 j, n): the own one is nominal, that of other joints an effect."""
    return np.vstack([motion.ddq.T, motion.dq.T**2])


GRAVITY = Process(_gravity_kernel, lambda motion: np.ones(len(motion.dq)), own_gravity, 1e-9)
INERTIA = Process(
    _inertia_kernel,
    lambda motion: np.asarray(np.sum(motion.ddq**2, axis=1) + np.sum(motion.dq**2, axis=1) ** 2),
    constant_coupling,
    1e-7,
)
PROCESSES = (GRAVITY, INERTIA)


def pivoted_cholesky(process: Process, motion: ChainMotion, most: int = MOST_COLUMNS) -> Columns:
    """Return the columns of a process at samples of equal weight, without its effects."""
    # Row by row, because LAPACK's dpstrf needs the whole matrix of some thousand samples squared.
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
    motion: ChainMotion, weight: Float, known: Float, y: Float, every: int = 1, most: int = MOST_COLUMNS
) -> Float:
    """Return the columns of both processes, with standard normal coefficients in units of the noise, shape (k, m).

    Expectation maximisation (D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320) gives their variances and that of the
    noise, for a torque y, shape (m,), known columns, shape (b, m), and the excluded effects. Samples have a weight
    each; one in ``every`` is a candidate of the Cholesky decomposition, which gives at most ``most`` columns each.
    """
    thin = motion.at(slice(None, None, every))
    columns = [weight * pivoted_cholesky(process, thin, most).at(motion) for process in PROCESSES]
    known = np.vstack([known, *(weight * process.effects(motion) for process in PROCESSES)])
    inside = np.linalg.qr((known / np.maximum(np.linalg.norm(known, axis=1), 1e-300)[:, None]).T)[0].T
    both, which = np.vstack(columns), np.repeat([0, 1], [len(one) for one in columns])
    free, left = (one - (one @ inside.T) @ inside for one in (both, y))
    noise = max(float(np.mean(left**2)), 1e-300)
    variances = noise / np.array([max(float(np.mean(np.sum(one**2, axis=0))), 1e-300) for one in columns])
    least, products, along = 1e-9 * variances, free @ free.T, free @ left
    for _ in range(EM_ITERATIONS):
        covariance = np.linalg.inv(products / noise + np.diag(1.0 / variances[which]))
        found = covariance @ along / noise
        noise = max(float(np.mean((left - found @ free) ** 2) + np.sum(covariance * products) / len(y)), 1e-300)
        power = np.bincount(which, found**2 + np.diag(covariance), 2) / np.maximum(np.bincount(which, minlength=2), 1)
        variances = np.maximum(power, least)
    return np.asarray(both * np.sqrt(variances[which] / noise)[:, None])


def project_out(basis: Float, rows: Float) -> Float:
    """Project an orthonormal basis, shape (k, m), out of rows, shape (p, m); a row within its span becomes zero."""
    if not len(basis):
        return rows
    left = rows - (rows @ basis.T) @ basis
    left[np.sum(left**2, axis=1) <= ROUNDING_SHARE**2 * np.sum(rows**2, axis=1)] = 0.0
    return np.asarray(left)
