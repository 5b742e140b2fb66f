"""One Gram matrix of whitened columns, by folds of whole cycles: every score of a selection is a small solve on it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.noise import NoiseModel
from friction_audit.diagnosis.problem import Nuisance, RegressionProblem
from friction_audit.effects.effect import Effect
from friction_audit.joint_log import Bool, Float, Int

COPY = 1e-5  # eigenvalue of a block given everything else, over its own size, of what is a copy of that
RIDGE = 1e-10
ByWidth = list[tuple[Int, Int, Float]]  # of blocks of one width each: numbers, columns, own products
AT_ONCE = 2**18  # numbers of a dictionary that are worked on at once: 2 MB stay in the cache of a core


class Gram:
    """Products of the nominal model, the nuisances and all blocks within each fold, of whitened columns.

    Whitening W acts within cycles, so that products of whitened columns are those of the columns with W'W x: no
    whitened copy of the dictionary is kept.
    """

    def __init__(
        self, problem: RegressionProblem, noise: NoiseModel, nuisances: Sequence[Nuisance], blocks: Sequence[Block]
    ) -> None:
        self.problem, self.noise, self.nuisances = problem, noise, tuple(nuisances)
        self.order = problem.order
        self.ends = np.searchsorted(problem.fold[self.order], np.arange(problem.folds + 1))
        self.slices = [slice(a, b) for a, b in pairwise(self.ends.tolist())]  # columns of each fold
        self.sorted_noise = replace(noise, age=noise.age[self.order], weight=noise.weight[self.order])
        self.base_raw = np.vstack([problem.X, *(one.column[None] for one in nuisances)])
        self.precision = np.append(np.zeros(len(problem.X)), [1.0 / one.sd**2 for one in nuisances])
        white = self.whiten(np.vstack([problem.y, self.base_raw]))
        self.y, self.base = white[0], white[1:]
        products = np.stack([white[:, f] @ white[:, f].T for f in self.slices])
        self.yy, self.by, self.bb = products[:, 0, 0], products[:, 1:, 0], products[:, 1:, 1:]
        self.blocks: list[Block] = []
        self.used = 0
        self.own: dict[int, Float] = {}
        # By block; of None: the response, then the base. Products within each fold, shape (folds, k, columns).
        self._left: dict[int | None, Float] = {None: self.sorted_noise.transposed(white)}
        self.cross: dict[int | None, Float] = {None: np.empty((problem.folds, len(white), 0))}
        self.version = 0
        # Blocks of one effect with the same parameters: which they are, and for each its columns and parameters.
        self._kinds: list[tuple[Effect, Int, Bool, dict[str, Float]]] = []
        self.add(blocks)

    def whiten(self, columns: Float) -> Float:
        """Innovations in the order of the folds, shape (k, m)."""
        return self.sorted_noise.whiten(np.atleast_2d(columns)[:, self.order])

    def add(self, blocks: Sequence[Block]) -> None:
        """Append blocks."""
        for block in blocks:
            block.start = self.used
            self.used += block.p
        found: dict[int, list[Float]] = {}
        products = self._products(np.vstack(list(self._left.values())), blocks, found)
        for p, parts in found.items():
            self.own[p] = np.concatenate([*([self.own[p]] if p in self.own else []), *parts], axis=1)
        ends = np.cumsum([len(left) for left in self._left.values()])
        for (key, known), more in zip(self.cross.items(), np.split(products, ends[:-1], axis=1), strict=True):
            self.cross[key] = np.concatenate([known, more], axis=2)
        self.blocks += blocks
        self.names = np.array([b.name for b in self.blocks])
        self.starts = np.array([b.start for b in self.blocks], int)
        self.widths = np.diff(self.starts, append=self.used)
        self.numbers = np.array([b.p + b.numbers for b in self.blocks], int)
        kinds: dict[tuple[str, int, frozenset[str]], list[int]] = {}
        for k in range(len(self.blocks) - len(blocks), len(self.blocks)):
            block = self.blocks[k]
            kinds.setdefault((block.name, len(block.there), frozenset(block.shape)), []).append(k)
        for places in kinds.values():
            some = [self.blocks[k] for k in places]
            at = {name: np.array([block.shape[name] for block in some]) for name in some[0].shape}
            self._kinds.append((some[0].effect, np.array(places), np.stack([block.there for block in some]), at))
        self.version += 1

    def possible(self, coefficients: Float) -> Bool:
        """Whether coefficients of all blocks, shape (blocks, most), are physically possible."""
        out, columns = np.zeros(len(self.blocks), bool), np.arange(coefficients.shape[1])
        for effect, which, there, at in self._kinds:
            whole = np.zeros(there.shape)
            whole[there] = coefficients[which][columns < self.widths[which, None]]
            out[which] = effect.possible(whole.T, at)
        return out

    def of(self, block: Block) -> Float:
        """Whitened columns of a block, shape (p, m)."""
        return self.sorted_noise.whiten(block.stored.astype(np.float64))

    def products(self, block: Block) -> Float:
        """Products of a block with all others within each fold, shape (folds, p, columns)."""
        if id(block) not in self.cross:
            self._left[id(block)] = self.sorted_noise.transposed(self.of(block))
            self.cross[id(block)] = self._products(self._left[id(block)], self.blocks)
        return self.cross[id(block)]

    def chunks(self, blocks: Sequence[Block]) -> Iterator[tuple[list[Block], Float]]:
        """Some blocks at a time with their columns in the order of the folds, shape (k, m), valid until the next."""
        m = len(self.y)
        room = np.empty((max(AT_ONCE // max(m, 1), *(b.p for b in blocks), 1), m))
        some: list[Block] = []
        columns = 0
        for block in (*blocks, None):
            if some and (block is None or columns + block.p > len(room)):
                yield some, np.concatenate([b.stored for b in some], out=room[:columns])
                some, columns = [], 0
            if block is not None:
                some.append(block)
                columns += block.p

    def _products(self, left: Float, blocks: Sequence[Block], own: dict[int, list[Float]] | None = None) -> Float:
        """Products within each fold; those of each block with itself are added to lists by width, where there are."""
        out = np.empty((self.problem.folds, len(left), sum(b.p for b in blocks)))
        first = 0
        for some, rows in self.chunks(blocks):
            if own is not None:
                for p, one in self._own(some, self.sorted_noise.whiten(rows)):
                    own.setdefault(p, []).append(one)
            for k, f in enumerate(self.slices):
                out[k, :, first : first + len(rows)] = left[:, f] @ rows[:, f].T
            first += len(rows)
        return out

    def _own(self, blocks: Sequence[Block], white: Float) -> Iterator[tuple[int, Float]]:
        """Products of blocks of each width with themselves within each fold, shape (folds, blocks, p, p)."""
        widths = np.array([block.p for block in blocks])
        starts = np.cumsum(widths) - widths
        for p in np.unique(widths).tolist():
            rows = white[starts[widths == p][:, None] + np.arange(p)]
            yield p, np.stack([rows[..., f] @ rows[..., f].transpose(0, 2, 1) for f in self.slices])


class Fit(NamedTuple):
    """The model with some blocks, fitted on some folds."""

    kept: Int  # rows of the base that take part: nuisances that a block replaces do not
    coefficients: Float  # of these and of the blocks, one after the other
    rss: float  # weighted residual sum of squares, priors included
    factor: Float  # of Cholesky, of the scaled Gram matrix
    scale: Float
    projected: Float  # the response in terms of the factor
    of_blocks: list[Float]  # coefficients of each block


@dataclass(eq=False)
class Training:
    """What some of the folds say: scores of all blocks given an active set."""

    gram: Gram
    folds: tuple[int, ...] = ()
    _version: int = -1  # of the Gram matrix, to which the next ones belong
    _sums: dict[int | None, Float] = field(default_factory=dict)
    _fits: dict[tuple[object, ...], Fit] = field(default_factory=dict)
    _own: dict[tuple[str, int], ByWidth] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.folds = self.folds or tuple(range(self.gram.problem.folds))

    @property
    def samples(self) -> float:
        """Effective samples."""
        gram = self.gram
        share = sum(gram.ends[k + 1] - gram.ends[k] for k in self.folds) / max(len(gram.y), 1)
        return float(gram.noise.effective_samples * share) - len(gram.problem.X)

    def _cross(self, block: Block | None) -> Float:
        if self._version != self.gram.version:
            self._version, self._sums, self._own = self.gram.version, {}, {}
        key = None if block is None else id(block)
        if key not in self._sums:
            by_fold = self.gram.cross[None] if block is None else self.gram.products(block)
            self._sums[key] = by_fold[list(self.folds)].sum(axis=0)
        return self._sums[key]

    def cross(self, active: Sequence[Block], fit: Fit) -> Float:
        """Products of the model with all columns of the blocks, scaled as its factor is, shape (b, columns)."""
        return np.vstack([self._cross(None)[1 + fit.kept], *(self._cross(b) for b in active)]) / fit.scale[:, None]

    def fit(self, active: Sequence[Block], unpinned: Sequence[str] = ()) -> Fit:
        """Fit the nominal model, nuisances and some blocks; nuisances of some names are left out."""
        key = (*map(id, active), "|", *unpinned)
        if key in self._fits:
            return self._fits[key]
        gram, folds = self.gram, list(self.folds)
        names = {b.name for b in active} | set(unpinned)
        out = [len(gram.problem.X) + k for k, one in enumerate(gram.nuisances) if names & set(one.replaced_by)]
        kept = np.setdiff1d(np.arange(len(gram.base)), out)
        at = np.concatenate([np.zeros(0, int), *(np.arange(b.start, b.start + b.p) for b in active)])
        n, cross = len(kept), self._cross(None)[np.append(0, 1 + kept)[:, None], at]
        whole = np.empty((n + len(at),) * 2)
        whole[:n, :n] = gram.bb[folds].sum(axis=0)[np.ix_(kept, kept)] + np.diag(gram.precision[kept])
        whole[:n, n:], whole[n:, :n] = cross[1:], cross[1:].T
        for block, rows in zip(active, np.split(whole[n:, n:], np.cumsum([b.p for b in active])), strict=False):
            rows[:] = self._cross(block)[:, at]
        right = np.append(gram.by[folds].sum(axis=0)[kept], cross[0])
        scale = np.sqrt(np.diag(whole))
        scale[scale == 0] = 1.0
        factor = np.linalg.cholesky(whole / scale[:, None] / scale + RIDGE * np.eye(len(whole)))
        projected = np.linalg.solve(factor, right / scale)
        total = float(gram.yy[folds].sum())
        rss = max(total - float(projected @ projected), 1e-12 * total)
        coefficients = np.linalg.solve(factor.T, projected) / scale
        of_blocks = np.split(coefficients, n + np.cumsum([0, *(b.p for b in active)]))[1:-1]
        self._fits[key] = Fit(kept, coefficients, rss, np.asarray(factor, np.float64), scale, projected, of_blocks)
        return self._fits[key]

    def gain(self, active: Sequence[Block]) -> tuple[Float, Float]:
        """L = n ln(RSS / RSS with the block) of every block given an active set; its coefficients, (blocks, most)."""
        known = self.gram.names
        gains, coefficients = np.zeros(len(known)), np.zeros((len(known), self.gram.widths.max(initial=1)))
        names = {n for one in self.gram.nuisances for n in one.replaced_by} - {b.name for b in active}
        self._gain(active, "", np.flatnonzero(~np.isin(known, list(names))), gains, coefficients)
        for name in names.intersection(known.tolist()):
            which = np.flatnonzero(known == name)
            # A nuisance that stands for the effect is left out with it, so that the two compete for the same torque.
            lost = self.samples * np.log(self.fit(active, (name,)).rss / self.fit(active).rss)
            self._gain(active, name, which, gains, coefficients)
            gains[which] -= lost
        return gains, coefficients

    def _gain(self, active: Sequence[Block], unpinned: str, which: Int, gains: Float, coefficients: Float) -> None:
        from scipy.linalg import solve_triangular

        fit = self.fit(active, (unpinned,) if unpinned else ())
        cross = self.cross(active, fit)
        zy_all = self._cross(None)[0]
        for members, cols, own in self._by_width(unpinned, which):
            t = solve_triangular(fit.factor, cross[:, cols.ravel()], lower=True, check_finite=False)
            t = np.asarray(t).reshape(-1, *cols.shape)
            zy = zy_all[cols] - np.einsum("a,aup->up", fit.projected, t)
            size = np.sqrt(np.maximum(np.einsum("upp->up", own), 1e-300))
            if cols.shape[1] == 1:
                left = own[:, 0, 0] - np.einsum("aup,aup->u", t, t)
                good = left > COPY * own[:, 0, 0]
                solution = np.where(good, zy[:, 0] / np.where(good, left, 1.0), 0.0)
                reduction, found = zy[:, 0] * solution, solution[:, None]
            else:
                left = own - np.einsum("aup,auq->upq", t, t)
                values, vectors = np.linalg.eigh(left / size[:, :, None] / size[:, None, :])
                along = np.einsum("upe,up->ue", vectors, zy / size)
                good = values > COPY
                scaled = np.where(good, along / np.where(good, values, 1.0), 0.0)
                reduction, found = (along * scaled).sum(axis=1), np.einsum("upe,ue->up", vectors, scaled) / size
            gains[members] = self.samples * np.log(fit.rss / np.maximum(fit.rss - reduction, 1e-12 * fit.rss))
            coefficients[members, : cols.shape[1]] = found

    def _by_width(self, unpinned: str, which: Int) -> ByWidth:
        gram, key = self.gram, (unpinned, len(which))
        if key not in self._own:
            self._own[key] = found = []
            for p in np.unique(gram.widths[which]).tolist():
                members = which[gram.widths[which] == p]
                place = np.searchsorted(np.flatnonzero(gram.widths == p), members)
                own = np.sum([gram.own[p][fold][place] for fold in self.folds], axis=0)
                found.append((members, gram.starts[members][:, None] + np.arange(p), own))
        return self._own[key]
