"""Whether the noise of a joint is slow, and the joint with what it foretells of itself taken off."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.confirmation import evidence
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.library import Library
from friction_audit.diagnosis.naming import Names, on_rows
from friction_audit.diagnosis.noise import Index, autocovariance
from friction_audit.diagnosis.prewhitening import Prewhitening, SlowNoise, prewhitening
from friction_audit.diagnosis.ranking import BY_CHANCE
from friction_audit.joint_log import Float

SLOW = 3.0
"""How many rows that white noise leaves independent are worth one, from which noise is slow."""
LONG_S = 0.05
"""And its memory. What is slower than white for less is a Panda's own noise and the rows' filter: its news are what is
near the corner, where every formula is least well known."""
LAGS = 16
"""Spacings of such rows at which the correlation is looked at."""
MEMORIES = np.geomspace(1.0, 30.0, 60)
"""In such spacings."""
MOST = 0.98
"""Share of the noise that is slow: a filter leaves no noise that is nowhere white."""


def slow_noise(ground: Ground, effects: Sequence[Float]) -> SlowNoise | None:
    """The slow noise that a model, and curves beside it, leave of the working rows; None where it is not slow.

    Curves take part of a slow noise, and a model leaves what it misses: the shorter memory of two counts.

    Args:
        ground: The joint.
        effects: Columns of what was found, shape (m, p) each.
    """
    lag = max(round(0.5 / (ground.rows.corner_hz * ground.rows.step_s)), 1)
    curves = np.hstack([*(curve.group.shapes[0] for curve in ground.curves), ground.rigid])
    both = [_fitted(_left(ground, *effects, *more), ground.run[ground.working], lag) for more in ([], [curves])]
    noise = min(both, key=lambda one: one.share * one.memory)
    long = noise.memory * ground.rows.step_s >= LONG_S
    return noise if long and 2.0 * noise.share * noise.memory >= SLOW * lag else None


def _left(ground: Ground, *columns: Float) -> Float:
    model = np.hstack([ground.base, *columns])[ground.working]
    return Beside(model, ground.y[ground.working]).response


def _fitted(residual: Float, run: Index, lag: int) -> SlowNoise:
    """The noise whose autocorrelation is nearest to that of a residual, looked at every so many rows.

    White where nothing is left, or no stretch is long enough to tell.
    """
    sums, pairs = autocovariance(residual, run, LAGS * lag)
    weight = pairs[lag::lag].astype(float)
    if sums[0] <= 0.0 or not weight.any():
        return SlowNoise(share=0.0, memory=1.0)
    found = sums[lag::lag] / np.maximum(weight, 1.0) * pairs[0] / sums[0]
    decays = np.exp(-np.arange(1, LAGS + 1) / MEMORIES[:, None])
    shares = np.clip((decays * weight) @ found / ((decays**2) @ weight), 0.0, MOST)
    best = int(np.argmin((found - shares[:, None] * decays) ** 2 @ weight))
    return SlowNoise(share=float(shares[best]), memory=float(MEMORIES[best]) * lag)


def news_of(ground: Ground, noise: SlowNoise) -> Prewhitening:
    """What makes news of a joint's rows.

    Working rows and locked ones foretell nothing of each other, a moment of break-away nothing at all.
    """
    place = np.flatnonzero(ground.rows.used)
    kind = np.where(np.isin(place, ground.rows.breakaway_row), -1, ground.working)
    return prewhitening(noise, place, kind)


def prewhitened(ground: Ground, news: Prewhitening) -> Ground:
    """The joint as news of its rows, of which the noise hardly remembers."""
    return replace(
        ground,
        rows=replace(ground.rows, y=news.of(ground.rows.y), prewhitening=news),
        declared=replace(ground.declared, columns=news.of(ground.base), y=news.of(ground.y)),
        curves=tuple(replace(curve, group=_group(curve.group, news)) for curve in ground.curves),
        surface=_group(ground.surface, news),
        rigid=news.of(ground.rigid),
    )


def told_by_both(ground: Ground, library: Library, plain: Names, news: Names) -> Names:
    """Names that were found in news, and of those that were found without it what news has no other name for.

    The rows as they are must tell them too. In news what changes fast counts most, and there a small flaw of a formula
    is the companion of another effect; what changes slowly, as a drift, is no news.

    Args:
        ground: The joint as it was measured.
        library: All that was looked for: what was disproved on the way is not in that of either.
        plain: What was found on its rows.
        news: What was found in their news.
    """
    from scipy.special import chdtri

    taken = {name for f in news.found for name in (f.candidate.name, *f.naming.alternatives)}
    slow = [f for f in plain.found if f.candidate.name not in taken]
    found = (*on_rows(ground, news).found, *slow)
    numbers = np.array([f.columns.shape[1] for f in found])
    there = evidence(ground, [f.columns for f in found]) >= chdtri(numbers, BY_CHANCE)
    if not there[: len(news.found)].any():
        return plain
    kept = tuple(f for f, is_there in zip(found, there, strict=True) if is_there)
    return replace(news, found=kept, library=library)


def _group(group: Group, news: Prewhitening) -> Group:
    return replace(group, shapes=tuple(news.of(shape) for shape in group.shapes))
