"""Which other names would explain an effect as well.

References:
    Q. H. Vuong, Likelihood ratio tests for model selection and non-nested hypotheses, Econometrica 57 (1989) 307.
    R. E. Kass, A. E. Raftery, Bayes factors, Journal of the American Statistical Association 90 (1995) 773: a
    difference of 6 in BIC is strong evidence.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.discrepancy.search import CycleProducts, Ranking, Search
from friction_audit.joint_log import Float

BEATEN_BY = 6.0
"""Difference in BIC from which one effect beats another (Kass and Raftery 1995)."""
ALIKE = 0.7
"""Correlation, free of all else in the model, above which two effects look the same."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Rival:
    """Another candidate in the place of an accepted effect, with its best admissible shape, all else kept.

    Attributes:
        name: Name of the candidate.
        shape: Index of its shape.
        delta_bic: BIC of the rival less BIC of the effect, on the effective number of samples; above 0 it is worse.
        correlation: Of the two effects' torques free of all else in the model, 0..1.
        vuong_z: Vuong's statistic over cycles, above 0 if the accepted effect is nearer to the truth.
    """

    name: str
    shape: int
    delta_bic: float
    correlation: float
    vuong_z: float

    def beaten(self, vuong_z: float | None = None) -> bool:
        """Whether the log decides against it: by BIC, and over cycles too where a quantile is given."""
        return self.delta_bic >= BEATEN_BY and (vuong_z is None or self.vuong_z >= vuong_z)


@dataclass(frozen=True, kw_only=True, slots=True)
class Naming:
    """An accepted effect and what it may be instead.

    Attributes:
        name: Name of the effect.
        rivals: All other candidates that could take its place, the best first.
        alternatives: Names of those that this log does not tell apart from it.
    """

    name: str
    rivals: tuple[Rival, ...]
    alternatives: tuple[str, ...]


def name_effects(
    products: CycleProducts,
    found: Search,
    n_eff: float,
    same_as: Mapping[str, Sequence[str]],
    *,
    alike: float = ALIKE,
    vuong_z: float | None = None,
) -> tuple[Naming, ...]:
    """For every accepted effect the set of names that fit.

    An alternative is not beaten by a difference of 6 in BIC on the effective number of samples (nor, where asked, by
    Vuong's test over cycles) and runs alike: its torque, free of all else in the model, correlates above 0.7 with that
    of the effect. Names that no motion of this kind tells apart always belong to the set.

    Args:
        products: Cross products of the data.
        found: The accepted effects.
        n_eff: Number of independent samples that the data are worth.
        same_as: For each name those that are the same in any log of this kind.
        alike: Correlation above which two effects look the same; 0 leaves the decision to the evidence alone.
        vuong_z: Quantile that Vuong's statistic must reach besides; None leaves it out.

    Returns:
        One entry for each effect, in the order of the search.
    """
    taken = {chosen.name for chosen in found.chosen}
    entries = []
    for chosen in found.chosen:
        rivals = _rivals(products, [c.unit for c in found.chosen], chosen.unit, n_eff)
        close = [r.name for r in rivals if not r.beaten(vuong_z) and r.correlation > alike]
        names = dict.fromkeys([*close, *(name for name in same_as.get(chosen.name, ()) if name not in taken)])
        entries.append(Naming(name=chosen.name, rivals=rivals, alternatives=tuple(names)))
    return tuple(entries)


def vuong(rss_first: Float, rss_second: Float, samples: Float, n_eff: float, extra_columns: int = 0) -> float:
    """Vuong's statistic of two models over cycles, positive where the first is nearer to the truth.

    The log likelihood of cycle c is -n_c/2 ln(s^2) - RSS_c / (2 s^2) with each model's own s^2 = RSS / n; the
    statistic is the sum of the differences d_c over the root of C var(d_c) (Vuong 1989, models that are not nested),
    after Schwarz's correction for the number of columns. Cycles are the independent observations.

    Args:
        rss_first: Residual sum of squares of each cycle under the first model, shape (c,).
        rss_second: The same under the second.
        samples: Samples of each cycle, shape (c,).
        n_eff: Number of independent samples that the data are worth.
        extra_columns: Columns of the first model less those of the second.

    Returns:
        Normal under the hypothesis that both are equally near; 0 if the models are the same.
    """
    n = float(samples.sum())
    first, second = rss_first.sum() / n, rss_second.sum() / n
    d = 0.5 * (samples * np.log(second / first) + rss_second / second - rss_first / first) * n_eff / n
    spread = np.sqrt(len(d)) * float(np.std(d, ddof=1))
    if not spread > 1e-12 * n_eff:
        return 0.0
    return float((d.sum() - 0.5 * extra_columns * np.log(n_eff)) / spread)


def _rivals(products: CycleProducts, active: list[int], unit: int, n_eff: float) -> tuple[Rival, ...]:
    """Every other candidate in the place of one effect, with its best admissible shape."""
    others = [u for u in active if u != unit]
    ranking = Ranking(products, products.total(), n_eff)
    scores = ranking.scores(others)
    best: dict[int, int] = {products.units[unit].group: unit}
    for u in np.argsort(-scores, kind="stable"):
        group = products.units[int(u)].group
        if np.isfinite(scores[u]) and group not in best and ranking.admissible([*others, int(u)], int(u)):
            best[group] = int(u)
    pairs = [u for u in best.values() if u != unit]
    return tuple(_rival(products, ranking, scores, others, unit, u) for u in pairs)


def _rival(products: CycleProducts, ranking: Ranking, scores: Float, others: list[int], unit: int, rival: int) -> Rival:
    entry = products.units[rival]
    extra = int(ranking.width[unit] - ranking.width[rival])
    samples = products.samples.astype(float)
    first, second = (_block_rss(products, ranking, [*others, u]) for u in (unit, rival))
    return Rival(
        name=products.names[entry.group],
        shape=entry.shape,
        delta_bic=float(scores[unit] - scores[rival]),
        correlation=_correlation(ranking, others, unit, rival),
        vuong_z=vuong(first, second, samples, ranking.n_eff, extra),
    )


def _block_rss(products: CycleProducts, ranking: Ranking, active: list[int]) -> Float:
    """Residual sum of squares of each block with everything fitted on all, shape (g,)."""
    cols = np.concatenate([[0], ranking.columns(active)])
    turn = np.concatenate([[1.0], -ranking.factors(active)])
    return np.asarray(np.einsum("i,gij,j->g", turn, products.gram[:, cols[:, None], cols], turn))


def _correlation(ranking: Ranking, others: list[int], unit: int, rival: int) -> float:
    """Correlation of the torques that two units would each explain, free of base and other effects."""
    one, two = (ranking.products.units[u].columns for u in (unit, rival))
    cols = ranking.columns(others)
    every = np.concatenate([[0], one, two])
    lean = np.linalg.lstsq(ranking.gram[np.ix_(cols, cols)], ranking.gram[np.ix_(cols, every)], rcond=1e-12)[0]
    free = ranking.gram[np.ix_(every, every)] - ranking.gram[np.ix_(every, cols)] @ lean
    a, b = slice(1, 1 + len(one)), slice(1 + len(one), None)
    first = np.linalg.lstsq(free[a, a], free[a, 0], rcond=1e-8)[0]
    second = np.linalg.lstsq(free[b, b], free[b, 0], rcond=1e-8)[0]
    size = (first @ free[a, a] @ first) * (second @ free[b, b] @ second)
    return float(abs(first @ free[a, b] @ second) / np.sqrt(size)) if size > 0 else 0.0
