"""Scores of candidates cycle by cycle, and what random signs per cycle make of them, many shapes at a time.

With W the columns of a shape free of the base and e the residual of the base, the score of cycle c is s_c = W_c' e_c. A
draw gives each cycle a weight g_c and refits the base, so that s*_c = g_c s_c - W_c' X_c h with
h = (X'X)^-1 sum g_c X_c' e_c. All of it follows from cross products within each cycle: no draw touches a sample.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.cross_products import MIN_FRACTION_LEFT
from friction_audit.diagnosis.groups import Group
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

Index = NDArray[np.int64]
BLOCK = 64
"""Products of two columns, of all shapes, that are looked at together: as many as a processor's cache holds."""
SMALLEST_TAIL = 1e-280
"""Smallest p-value that is computed and not extrapolated."""
RIDGE = 1e-10
"""Of a spread, at the level of rounding: a direction in which no cycle has any score carries no evidence."""


class CycleScores:
    """Sums over cycles of base and residual, and the statistics of a candidate with all their draws."""

    def __init__(
        self,
        y: Float,
        base: Float,
        number: Index,
        cycles: int,
        weights: Float,
        sample_weight: Float | None = None,
        at: Index | None = None,
    ) -> None:
        """Read response (n,), base (n, b) and the number of the cycle of each sample, and take draws (draws, c).

        Samples of candidates are multiplied by a weight (n,), as those of response and base have been; ``at`` tells
        which of theirs they are, all if None.
        """
        order = np.argsort(number, kind="stable")
        self.at = order if at is None else at[order]
        self.bounds = np.searchsorted(number[order], np.arange(cycles + 1))
        self.weights = weights
        even = sample_weight is None or bool(np.all(sample_weight == 1.0))
        self.sample_weight = None if sample_weight is None or even else sample_weight[order]
        rows = base.T[:, order]
        self.inverse = np.linalg.pinv(rows @ rows.T, rcond=1e-12, hermitian=True)
        response = y[order]
        residual = response - rows.T @ (self.inverse @ (rows @ response))
        self.with_residual = np.ascontiguousarray(np.concatenate([residual[None], rows]).T)
        own = self._per_cycle(rows)
        self.base_score, self.base_gram = own[:, :, 0], own[:, :, 1:]
        moved = weights @ self.base_score @ self.inverse
        # What the products in ``_spread`` are multiplied by: g_c^2, h h' and -g_c h'.
        terms = (weights**2, moved[:, :, None] * moved[:, None, :], -weights[:, :, None] * moved[:, None, :])
        self.factors = np.concatenate([term.reshape(len(weights), -1) for term in terms], axis=1)

    def _per_cycle(self, rows: Float) -> Float:
        """Cross products of rows (k, n) with residual and base in every cycle, shape (c, k, 1 + b)."""
        return np.stack([rows[:, i:j] @ self.with_residual[i:j] for i, j in pairwise(self.bounds)])

    def largest(self, group: Group) -> tuple[float, Float]:
        """Largest statistic of all shapes, and the same in each draw, shape (draws,)."""
        form: dict[int, Float] = {}
        for block in _blocks(group.shapes):
            forms, ranks = self._forms(group.name, self._rows(block))
            for rank in np.unique(ranks).tolist():
                highest = forms[:, ranks == rank].max(axis=1)
                form[rank] = np.maximum(form.get(rank, highest), highest)
        cycles = len(self.base_score)
        # Of shapes that are alike in rank the evidence rises with the form: only the largest need be looked up.
        evidence = [marginal_evidence(highest, cycles, rank) for rank, highest in form.items() if rank > 0]
        most = np.max([np.zeros(1 + len(self.weights)), *evidence], axis=0)
        return float(most[0]), most[1:]

    def _rows(self, shapes: Sequence[Float]) -> Float:
        """Columns of some shapes of one width, one below the other, shape (s, p, n)."""
        rows = np.empty((len(shapes), shapes[0].shape[1], len(self.at)))
        for own, shape in zip(rows, shapes, strict=True):
            shape.T.take(self.at, axis=1, out=own, mode="clip")  # its other modes make a copy first
        if self.sample_weight is not None:
            rows *= self.sample_weight
        return rows

    def _forms(self, name: str, rows: Float) -> tuple[Float, Index]:
        """Quadratic forms of the data, then of each draw, (1 + draws, s), from rows (s, p, n); and ranks (s,)."""
        shapes, width, samples = rows.shape
        gram = rows @ rows.transpose(0, 2, 1)
        norm = np.sqrt(np.diagonal(gram, axis1=1, axis2=2))
        if not np.all(np.isfinite(norm)):
            raise AnalysisError(f"candidate {name}: values that are not finite, expected numbers; leave it out")
        # Columns with a norm of 1 have these products: nothing depends on units of measurement.
        norm = np.where(norm > 0, norm, 1.0)
        gram /= norm[:, :, None] * norm[:, None, :]
        products = self._per_cycle(rows.reshape(-1, samples)).reshape(len(self.base_score), shapes, width, -1)
        products /= norm[:, :, None]
        s, A = products[..., 0], products[..., 1:]
        total = A.sum(axis=0)
        lean = total @ self.inverse
        turn = _orthonormal(gram - lean @ total.transpose(0, 2, 1))
        s = np.einsum("csp,spr->csr", s - np.einsum("ca,spa->csp", self.base_score, lean), turn)
        A = np.einsum("spr,cspb->csrb", turn, A - np.einsum("spa,cab->cspb", lean, self.base_gram))
        drawn = quadratic_form(self._sums(s), self._spread(s, A))
        own = quadratic_form(s.sum(axis=0)[None], np.einsum("csp,csq->spq", s, s)[None])
        return np.concatenate([own, drawn]), np.count_nonzero(turn.any(axis=1), axis=1)

    def _sums(self, s: Float) -> Float:
        return (self.weights @ s.reshape(len(s), -1)).reshape(-1, *s.shape[1:])

    def _spread(self, s: Float, A: Float) -> Float:
        """Sum over cycles of s*_c s*_c' for every draw, (draws, s, p, p), from products of small matrices only."""
        cycles, shapes, p, b = A.shape
        products = np.empty((cycles + b * b + cycles * b, shapes, p, p))
        np.multiply(s[:, :, :, None], s[:, :, None, :], out=products[:cycles])
        flat = A.transpose(1, 2, 3, 0).reshape(shapes, p * b, cycles)
        AA = (flat @ flat.transpose(0, 2, 1)).reshape(shapes, p, b, p, b).transpose(2, 4, 0, 1, 3)
        products[cycles : cycles + b * b] = AA.reshape(b * b, shapes, p, p)
        sA = s[:, None, :, :, None] * A.transpose(0, 3, 1, 2)[:, :, :, None, :]
        np.add(sA, sA.transpose(0, 1, 2, 4, 3), out=products[-cycles * b :].reshape(sA.shape))
        spread: Float = (self.factors @ products.reshape(len(products), -1)).reshape(-1, shapes, p, p)
        return spread


def _blocks(shapes: Sequence[Float]) -> Iterator[list[Float]]:
    """Shapes of one width, so many at a time."""
    widths = np.array([shape.shape[1] for shape in shapes])
    for width in np.unique(widths).tolist():
        alike = np.flatnonzero(widths == width).tolist()
        size = max(BLOCK // width**2, 1)
        for first in range(0, len(alike), size):
            yield [shapes[k] for k in alike[first : first + size]]


def _orthonormal(gram: Float) -> Float:
    """How to combine columns with these cross products (s, p, p) to orthonormal ones or zeros, shape (s, p, p)."""
    value, vector = np.linalg.eigh(gram)
    good = value > MIN_FRACTION_LEFT
    turn: Float = vector * np.where(good, 1.0 / np.sqrt(np.where(good, value, 1.0)), 0.0)[:, None, :]
    return turn


def quadratic_form(total: Float, spread: Float) -> Float:
    """Total' spread^-1 total, shape (...), for totals (..., p) and spreads (..., p, p); 0 where nothing spreads."""
    if total.shape[-1] == 1:
        v = spread[..., 0, 0]
        form: Float = np.where(v > 0, total[..., 0] ** 2 / np.where(v > 0, v, 1.0), 0.0)
        return form
    size = np.trace(spread, axis1=-2, axis2=-1)
    ridge = np.where(size > 0, size, 1.0) * RIDGE
    if total.shape[-1] == 2:  # noqa: PLR2004 - written out: most candidates with several columns have two
        (x, y), (a, b, d) = np.moveaxis(total, -1, 0), (spread[..., 0, 0], spread[..., 0, 1], spread[..., 1, 1])
        a, d = a + ridge, d + ridge
        return np.asarray((d * x**2 - 2.0 * b * x * y + a * y**2) / (a * d - b**2))
    safe = spread + ridge[..., None, None] * np.eye(total.shape[-1])
    return np.asarray(np.sum(total * np.linalg.solve(safe, total[..., None])[..., 0], axis=-1))


def marginal_evidence(q: Float, cycles: int, p: int) -> Float:
    """-ln of the p-value of q / cycles as a Beta(p/2, (cycles - p)/2) variate, shape of q.

    For independent normal scores q / cycles has this distribution exactly (it is Hotelling's T squared about zero).
    Read from a table over u = -ln(1 - q / cycles), in which it becomes a straight line of slope (cycles - p)/2.
    """
    u, evidence = _evidence_table(cycles, p)
    asked = -np.log1p(-np.clip(q / cycles, 0.0, 1.0 - 1e-15))
    beyond = np.maximum(asked - u[-1], 0.0) * (cycles - p) / 2.0
    return np.asarray(np.interp(asked, u, evidence) + beyond)


@lru_cache(maxsize=64)
def _evidence_table(cycles: int, p: int) -> tuple[Float, Float]:
    """Values of u and -ln of the tail of the Beta distribution there, as far as it can be represented."""
    from scipy.special import betaincc

    u = np.linspace(0.0, 30.0, 3001)
    tail = betaincc(p / 2.0, (cycles - p) / 2.0, -np.expm1(-u))
    sure = tail > SMALLEST_TAIL
    return u[sure], -np.log(tail[sure])
