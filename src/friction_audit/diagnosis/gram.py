"""Cross products of columns: of those of one candidate with each other, and of a few columns with all.

Columns that lie one behind the other in one array are multiplied at one go: what takes the time is to read them.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

Index = NDArray[np.int64]
Kept = NDArray[np.bool_] | None
"""Samples that count, all if None, shape (n,)."""
SAMPLES_AT_A_TIME = 4096
"""So many of a candidate's columns fit the cache that cores share."""


def products_within(columns: Sequence[Float], kept: Kept, known: Float | None = None) -> Float:
    """Products of the columns of some arrays, shape (n, p) each or (n,), with each other, shape (k, k).

    Args:
        columns: The arrays.
        kept: Samples that count.
        known: Those of arrays that are known, not numbers at the others, shape (k, k).
    """
    widths = _widths(columns)
    gram = np.full((widths.sum(),) * 2, np.nan) if known is None else known.copy()
    lacks = _any_of(~np.isfinite(np.diag(gram)), widths)
    old, new = np.flatnonzero(~lacks).tolist(), np.flatnonzero(lacks).tolist()
    if new:
        added = _places(lacks, widths)
        gram[np.ix_(added, added)] = _among([columns[k] for k in new], kept)
    if old and new:
        here = _places(~lacks, widths)
        both = _with_all(_counted(np.concatenate([_across(columns[k]) for k in new]), kept), [columns[k] for k in old])
        gram[np.ix_(added, here)], gram[np.ix_(here, added)] = both, both.T
    return gram


def fill_in(gram: Float, columns: Sequence[Float], wanted: list[int], kept: Kept, scale: Float | None = None) -> None:
    """Write the products of some columns with all others that lack one of them.

    Args:
        gram: Products over the scales, no numbers where they are not known, shape (k, k).
        columns: All arrays, shape (n, p) each or (n,).
        wanted: Numbers of columns.
        kept: Samples that count.
        scale: Of each column, shape (k,); 1 if None.
    """
    widths = _widths(columns)
    lacks = _any_of(np.asarray(np.isnan(gram[wanted]).any(axis=0)), widths)
    lacking = np.flatnonzero(lacks).tolist()
    if not lacking:
        return
    there = _places(lacks, widths)
    rows = _with_all(_counted(_rows_of(columns, wanted), kept), [columns[k] for k in lacking])
    if scale is not None:
        rows /= scale[wanted, None] * scale[there]
    here = np.asarray(wanted)
    gram[np.ix_(here, there)], gram[np.ix_(there, here)] = rows, rows.T


def _rows_of(columns: Sequence[Float], wanted: list[int]) -> Float:
    """Some columns, by their number among those of all arrays, as rows, shape (w, n)."""
    ends = np.cumsum(_widths(columns))
    arrays = np.searchsorted(ends, wanted, side="right").tolist()
    own = [_across(columns[k])[column - int(ends[k])] for k, column in zip(arrays, wanted, strict=True)]
    return np.stack(own)


def places_of(columns: Sequence[Float]) -> list[Index]:
    """Where each array has its columns among those of all."""
    ends = np.append(0, np.cumsum(_widths(columns)))
    every = np.arange(ends[-1])
    return [every[i:j] for i, j in pairwise(ends.tolist())]


def _widths(columns: Sequence[Float]) -> Index:
    """How many columns each array has."""
    return np.array([1 if column.ndim == 1 else column.shape[1] for column in columns], int)


def _any_of(true: NDArray[np.bool_], widths: Index) -> NDArray[np.bool_]:
    """Whether something is true of any column of an array, for each array."""
    so_far = np.append(0, np.cumsum(true))
    ends = np.cumsum(widths)
    return np.asarray(so_far[ends] > so_far[ends - widths])


def _places(chosen: NDArray[np.bool_], widths: Index) -> Index:
    """Where the columns of chosen arrays lie among those of all."""
    return np.flatnonzero(np.repeat(chosen, widths))


def _across(column: Float) -> Float:
    """An array (n, p) or (n,) as rows, shape (p, n)."""
    rows = np.asarray(column, float)
    return rows[None] if rows.ndim == 1 else rows.T


def _counted(rows: Float, kept: Kept) -> Float:
    """Rows (w, n) with zeros at samples that do not count: no other array need be thinned out."""
    if kept is not None:
        rows[:, ~kept] = 0.0
    return rows


def _with_all(rows: Float, columns: Sequence[Float]) -> Float:
    return np.concatenate([rows @ stack.T for stack in _stacks(columns)], axis=1)


def _among(columns: Sequence[Float], kept: Kept) -> Float:
    """Products of columns with each other, (k, k); some samples at a time, for memory that is new is slow."""
    stacks = list(_stacks(columns))
    many = sum(map(len, stacks))
    gram = np.zeros((many, many))
    stretches = _stretches(np.ones(stacks[0].shape[1], bool) if kept is None else kept)
    block = np.empty((many, max((samples for _, samples in stretches), default=0)))
    for some, samples in stretches:
        own = block[:, :samples]
        at = 0
        for i, j in some:
            first = 0
            for stack in stacks:
                own[first : first + len(stack), at : at + j - i] = stack[:, i:j]
                first += len(stack)
            at += j - i
        gram += own @ own.T
    return gram


def _stretches(kept: NDArray[np.bool_]) -> list[tuple[list[tuple[int, int]], int]]:
    """Stretches of samples that count, from and to, as many together as make a block; and how many samples it has."""
    blocks: list[tuple[list[tuple[int, int]], int]] = []
    for begin, end in np.flatnonzero(np.diff(kept, prepend=False, append=False)).reshape(-1, 2).tolist():
        for i in range(begin, end, SAMPLES_AT_A_TIME):
            j = min(i + SAMPLES_AT_A_TIME, end)
            if not blocks or blocks[-1][1] + j - i > SAMPLES_AT_A_TIME:
                blocks.append(([], 0))
            some, samples = blocks[-1]
            blocks[-1] = ([*some, (i, j)], samples + j - i)
    return blocks


def _stacks(columns: Sequence[Float]) -> Iterator[Float]:
    """All columns as rows, shape (k, n), as many in one array as lie one behind the other."""
    run: list[Float] = []
    end = 0
    for column in columns:
        own = _across(column)
        begin = _address(own) if _whole(own) else 0
        if run and not (begin and begin == end and own.base is run[0].base and own.shape[1] == run[0].shape[1]):
            yield _joined(run)
            run = []
        run.append(own)
        end = begin + own.nbytes if begin else 0
    if run:
        yield _joined(run)


def _whole(rows: Float) -> bool:
    """Whether rows are whole rows of an array that may hold others behind them."""
    base = rows.base
    return base is not None and base.flags.c_contiguous and rows.flags.c_contiguous and base.shape[-1] == rows.shape[1]


def _joined(run: Sequence[Float]) -> Float:
    """Rows that lie one behind the other in one array as one view of it."""
    first = run[0]
    if len(run) == 1 or first.base is None:
        return first
    row = (_address(first) - _address(first.base)) // (first.shape[1] * first.itemsize)
    return np.asarray(first.base.reshape(-1, first.shape[1])[row : row + sum(map(len, run))])


def _address(array: Float) -> int:
    return int(array.__array_interface__["data"][0])
