"""Channels whose columns are read when they are needed, so that one joint at a time is in memory."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from friction_audit.joint_log import Float, median_step

COARSE_HZ = 50.0  # of the means by which the sign of a torque is proved: above the motion, and cheap for hours of log


class ColumnsOnDemand:
    """Stands for an array of shape (n, j): a column is made each time that it is asked for, unless it is held.

    The first time, the means of its blocks of ``block`` samples are kept: what they are for needs no column again.
    """

    ndim, dtype = 2, np.dtype(np.float64)

    def __init__(self, rows: int, make: Sequence[Callable[[], Float]], block: int = 0, keep: int | None = None) -> None:
        """Remember how each column, shape (rows,), is made, and the number of the one to hold once it is made."""
        self.shape, self.block = (rows, len(make)), block
        self._make, self._keep = make, keep
        self._held: dict[int, Float] = {}
        self._means: dict[int, Float] = {}

    def __len__(self) -> int:
        """Return n."""
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:  # noqa: ANN401 - as of an array
        """Return some rows as an array; columns with all their rows stay on demand, one column is an array."""
        rows, columns = key if isinstance(key, tuple) else (key, slice(None))
        if isinstance(columns, int):
            return self._column(columns)[rows]
        numbers = range(self.shape[1])[columns] if isinstance(columns, slice) else columns
        if isinstance(rows, slice) and rows == slice(None):
            return ColumnsOnDemand(len(self), [partial(self._column, number) for number in numbers])
        return np.stack([self._column(number)[rows] for number in numbers], axis=-1)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Float:  # noqa: ANN401
        """Return all columns, for what needs them at once."""
        whole = np.empty(self.shape, order="F")
        for number in range(self.shape[1]):
            whole[:, number] = self._column(number)
        return whole

    def setflags(self, **_: bool) -> None:
        """Do nothing: a column that is made belongs to who asked for it."""

    def hold(self, number: int) -> "ColumnsOnDemand":
        """Return the same with one column that stays in memory once it was asked for."""
        return ColumnsOnDemand(len(self), self._make, keep=number)

    def block_means(self, number: int) -> Float:
        """Return the means of the blocks of a column."""
        if number not in self._means:
            self._column(number)
        return self._means[number]

    def _column(self, number: int) -> Float:
        if number in self._held:
            return self._held[number]
        column = self._make[number]()
        if self.block and number not in self._means:
            self._means[number] = block_means(column, self.block)
        if number == self._keep:
            self._held[number] = column
        return column


def block_means(column: Float, samples: int) -> Float:
    """Return the means of neighbouring blocks of samples, shape (n,) -> (n // samples,)."""
    blocks = len(column) // samples
    return np.asarray(column[: blocks * samples].reshape(blocks, samples).mean(axis=1))


def coarse_block(t: Float) -> int:
    """Return how many samples of a log lie in a block of COARSE_HZ."""
    return max(1, min(round(1.0 / median_step(t) / COARSE_HZ), len(t) // 2))


def is_on_demand(channel: object) -> bool:
    """Return True for a channel that is no array."""
    return isinstance(channel, ColumnsOnDemand)


def hold(channel: Float, number: int) -> Float:
    """Return a channel of which one column stays in memory once it was asked for."""
    held: Any = channel.hold(number) if isinstance(channel, ColumnsOnDemand) else channel
    return held  # type: ignore[no-any-return]
