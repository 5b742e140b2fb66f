"""Rows of which each holds only its news: less what the rows before it foretell of the noise.

A noise that is slow in part counts its rows for few where they are only added up. Yet what changes faster than it, as
friction does at a reversal, stands out of it. Taken off torque and columns alike, what is foretold leaves rows that are
almost independent (generalised least squares; the foretelling: R. E. Kalman, A new approach to linear filtering and
prediction problems, Journal of Basic Engineering 82 (1960) 35).
"""

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

FORGOTTEN = 5.0
"""Memories after which hardly anything is left."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SlowNoise:
    """A noise whose autocorrelation is ``share exp(-rows / memory)`` from one row on; the rest of it is white.

    Attributes:
        share: Of its variance, below 1.
        memory: In rows.
    """

    share: float
    memory: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Prewhitening:
    """How every row of a column is made news.

    Attributes:
        noise: What is foretold.
        steps: What is left of the foretold since the row before, how much of it is taken off, what of the news the
            next ones foretell, and by what the news are multiplied, that they be as noisy as the row was, shape (4, m).
    """

    noise: SlowNoise
    steps: Float

    def of(self, columns: Float) -> Float:
        """The news in columns, shape (m,) or (m, p)."""
        news = np.array(columns.T, np.float64, order="C")
        _news(np.atleast_2d(news), self.steps)
        return news.T

    def in_place(self, columns: Float) -> None:
        """The same, written over columns of shape (m,) or (m, p)."""
        _news(np.atleast_2d(columns.T), self.steps)

    def back(self, residual: Float) -> Float:
        """What a column's products with it are the products of the column's news with a residual of, shape (m,)."""
        return np.asarray(_back(residual, self.steps))

    def keep(self, kept: NDArray[np.bool_]) -> "Prewhitening":
        """The same for all rows of some kinds, shape (m,)."""
        return replace(self, steps=self.steps[:, kept])


def prewhitening(noise: SlowNoise, place: NDArray[np.int64], kind: NDArray[np.int64]) -> Prewhitening:
    """Work out the steps for rows that may be far from each other.

    Args:
        noise: What is foretold.
        place: Numbers of the rows, increasing, shape (m,).
        kind: Rows foretell those that follow until one of another kind; those below zero are passed over, shape (m,).
    """
    return Prewhitening(noise=noise, steps=_steps(place, kind, noise.share, 1.0 / noise.memory))


def response(noise: SlowNoise) -> Float:
    """News of a row of 1 that rows of 0 follow, long after the first row, until they are over, shape (r,)."""
    long = round(FORGOTTEN * noise.memory) + 1
    rows = np.arange(2 * long)
    return prewhitening(noise, rows, np.zeros_like(rows)).of(np.where(rows == long, 1.0, 0.0))[long:]


@compiled()
def _steps(place: NDArray[np.int64], kind: NDArray[np.int64], share: float, pace: float) -> Float:
    steps = np.empty((4, len(place)))
    last, unknown = -1, share
    for k in range(len(place)):
        if kind[k] < 0:
            steps[0, k], steps[1, k], steps[2, k], steps[3, k] = 1.0, 0.0, 0.0, 1.0
            continue
        known = last >= 0 and kind[last] == kind[k]
        left = np.exp(-pace * (place[k] - place[last])) if known else 0.0
        unknown = share + left**2 * (unknown - share)
        steps[0, k], steps[1, k] = left, 1.0
        steps[2, k], steps[3, k] = unknown / (unknown + 1.0 - share), 1.0 / sqrt(unknown + 1.0 - share)
        unknown *= 1.0 - steps[2, k]
        last = k
    return steps


@compiled()
def _news(columns: Float, steps: Float) -> None:
    for j in range(len(columns)):
        foretold = 0.0
        for k in range(columns.shape[1]):
            foretold *= steps[0, k]
            news = columns[j, k] - steps[1, k] * foretold
            foretold += steps[2, k] * news
            columns[j, k] = steps[3, k] * news


@compiled()
def _back(residual: Float, steps: Float) -> Float:
    """Go the way of the news from the end to the beginning."""
    torque, foretold = np.empty_like(residual), 0.0
    for k in range(len(residual) - 1, -1, -1):
        torque[k] = steps[3, k] * residual[k] + steps[2, k] * foretold
        foretold = steps[0, k] * (foretold - steps[1, k] * torque[k])
    return torque
