"""Whether the torque that an effect was fitted to on the working cycles is there on the locked ones."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import Clusters, Ground
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.omnibus import omnibus_test
from friction_audit.joint_log import Float

LEAST_GAIN = 0.005
"""Smallest gain of the root mean square that is worth a name: that of an effect of a tenth of what is left."""
AGREES, AGREES_PLAINLY = 0.2, 0.1
"""Largest p-value on locked cycles that does not speak against an effect that all cycles show: at the limit of
detection, n_eff rho^2 = 17 over all cycles, three in ten of them stay below it nine times in ten; and far above it."""
STAYS_Z = 1.645
"""Normal quantile of nineteen in twenty: a larger effect stays that often below a smaller p-value."""

HALF = 0.5
LEAST_HEARD = 1.0
"""n_eff rho^2 that locked cycles must hold of an effect to say anything of it: of a late step they may hold nothing."""
FEWEST_LIVELY = 5.0
"""Clusters of locked cycles that hold an effect, counted evenly. Signs of fewer agree by chance: rows are counted."""
WORSE_BY_CHANCE = 3.84
"""What the torque that was predicted may cost on the locked cycles, as n_eff ln(RSS with / RSS without): the 95 %
quantile of chi squared. An effect at the limit of detection costs more one time in twenty."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Confirmed:
    """What locked cycles say of each effect; k effects.

    Attributes:
        p_value: Family-wise p-value, shape (k,).
        gain: Share of the root mean square that the effect takes away, shape (k,).
        size: Root mean square of its torque free of all else, shape (k,). [N m]
        evidence: n_eff ln(RSS without / RSS with) over all cycles, shape (k,).
        least_evidence: The same with as few independent samples as the memory of all that is left allows, shape (k,).
        expected: What the locked cycles are expected to hold of that evidence, shape (k,).
        gain_of_all: Share of the root mean square that it takes away over all cycles, shape (k,).
        factors: Its factors over all cycles, k arrays of shape (p,).
        tolerated: The same, as near to those of the working cycles as chance may have moved them, k arrays.
        again: Factor of the torque that the working cycles predict, fitted on the locked ones, shape (k,).
        doubt: p-value of what may object to it, shape (k,): of the locked cycles; by what their rows are worth where
            few of them hold it; of all cycles, each predicted from the others, where no locked one holds it.
        cost: n_eff ln(RSS with / RSS without) on the locked cycles, both models as the working ones fitted them: below
            zero where the prediction helps, shape (k,).
    """

    p_value: Float
    gain: Float
    size: Float
    evidence: Float
    least_evidence: Float
    expected: Float
    gain_of_all: Float
    factors: tuple[Float, ...]
    tolerated: tuple[Float, ...]
    again: Float
    doubt: Float
    cost: Float

    @property
    def misleads(self) -> NDArray[np.bool_]:
        """Whether each effect makes the prediction of locked cycles worse than chance does, shape (k,).

        Its form may well be there with another factor; what was learned of it does not hold where it was not looked.
        """
        return np.asarray(self.cost > WORSE_BY_CHANCE)

    def proven(self, alpha: float) -> NDArray[np.bool_]:
        """Whether the locked cycles prove each effect, with a family-wise error of alpha, shape (k,)."""
        return np.asarray((self.p_value <= alpha) & (self.gain >= LEAST_GAIN))

    def shown(self, price: Float) -> NDArray[np.bool_]:
        """Whether all cycles pay the price of each effect and the locked ones do not object, shape (k,).

        Three cycles in ten miss an effect at the limit of detection one time in four, however plain it is on all. They
        object where the torque that was predicted for them leaves more than nothing did: a factor below a half. And
        they do not miss what is far above that limit, or it is a form that fits some of the cycles.

        Args:
            price: What evidence for each may be by chance, all that was tried counted, shape (k,).
        """
        from scipy.special import ndtr

        usual = ndtr(STAYS_Z - np.sqrt(np.maximum(self.expected, 0.0)))
        agrees = (holm(self.doubt) <= AGREES) & (self.doubt <= np.clip(usual, AGREES_PLAINLY, AGREES))
        agrees &= self.again > HALF
        return np.asarray(agrees & (self.evidence > price) & (self.gain_of_all >= LEAST_GAIN))


def confirm(ground: Ground, effects: Sequence[Float], rng: np.random.Generator) -> Confirmed:
    """Ask cycles that no choice was made on whether each effect is there, and how large it is.

    The torque that the working cycles predict is one column; on the locked cycles its factor is fitted beside the
    declared model and the other effects' torques, and must be above zero (wild cluster bootstrap; Holm's step-down
    over the effects). This has twice the power of asking whether each cycle's sum of squares falls. Size and gain are
    with that factor too: with the factor of the working cycles, which chance has made too large where an effect was
    just found, a small real effect seems to take nothing away.

    Args:
        ground: The joint.
        effects: Columns of each effect on the rows, shape (m, p) each.
        rng: Source of randomness.
    """
    from scipy.special import ndtr

    torques, locked, every = _torques(ground, effects), ground.locked, np.ones_like(ground.working)
    clusters = ground.clusters(locked, *effects)
    again = _factors(ground, locked, [torques[:, [k]] for k in range(len(effects))])
    p = np.array([_one_sided(ground, torques, k, clusters, rng, float(f[0])) for k, f in enumerate(again)])
    after = _left(ground, locked, torques)
    before = np.array([_left(ground, locked, np.delete(torques, k, axis=1)) for k in range(len(effects))])
    size = np.sqrt(np.maximum(before - after, 0.0) / locked.sum())
    without, with_all = _over_all(ground, effects)
    told_by_all, least = _told(without, with_all), np.finfo(float).tiny
    doubt, factor = p.copy(), np.concatenate(again)
    worth = len(ground.y) / ground.memory(*effects)
    for k in range(len(effects)):
        heard, lively = _heard(ground, torques, k, clusters)
        told = worth * locked.mean() * np.log(max(before[k], least) / max(after, least))
        if worth * heard < LEAST_HEARD * len(ground.y) * max(after, least) / locked.sum():
            doubt[k], factor[k] = _of_others(ground, effects, k, rng)
            size[k] = np.sqrt(max(without[k] - with_all, 0.0) / len(ground.y))
        elif lively < FEWEST_LIVELY and factor[k] > 0.0:
            doubt[k] = ndtr(-np.sqrt(max(told, 0.0)))
    return Confirmed(
        p_value=holm(p),
        gain=np.array([rms_gain(one, after) for one in before]),
        size=size,
        evidence=worth * told_by_all,
        least_evidence=len(ground.y) / ground.longest_memory(*effects) * told_by_all,
        expected=worth * told_by_all * locked.mean(),
        gain_of_all=np.array([rms_gain(one, with_all) for one in without]),
        factors=_factors(ground, every, effects),
        tolerated=_tolerated(ground, effects, worth),
        again=factor,
        doubt=doubt,
        cost=_cost(ground, effects),
    )


def evidence(ground: Ground, effects: Sequence[Float]) -> Float:
    """n_eff ln(RSS without / RSS with) of each effect beside the others, over all cycles, shape (k,)."""
    return len(ground.y) / ground.memory(*effects) * _told(*_over_all(ground, effects))


def _over_all(ground: Ground, effects: Sequence[Float]) -> tuple[Float, float]:
    """What is left of all cycles, without each effect in turn, shape (k,), and with them all: sums of squares."""
    every = np.ones_like(ground.working)
    without = [_left(ground, every, *effects[:k], *effects[k + 1 :]) for k in range(len(effects))]
    return np.array(without), _left(ground, every, *effects)


def _told(without: Float, with_all: float) -> Float:
    least = np.finfo(float).tiny
    return np.asarray(np.log(np.maximum(without, least) / max(with_all, least)))


def _tolerated(ground: Ground, effects: Sequence[Float], worth: float) -> tuple[Float, ...]:
    """Factors of each effect over all cycles, moved towards those of the working ones by what chance allows.

    A shape was refined on the working cycles until its factors were just possible; those of all cycles then lie beyond
    one time in two.
    """
    every = np.ones_like(ground.working)
    least = np.expm1(WORSE_BY_CHANCE / worth) * _left(ground, every, *effects)
    both = zip(_factors(ground, every, effects), _factors(ground, ground.working, effects), strict=True)
    moved = []
    for k, (factors, working) in enumerate(both):
        rest = np.hstack([ground.base, *effects[:k], *effects[k + 1 :]])
        torque = effects[k] @ (working - factors)
        cost = float(np.sum((torque - rest @ least_squares(rest, torque)) ** 2))
        moved.append(factors + (1.0 if cost <= least else np.sqrt(least / cost)) * (working - factors))
    return tuple(moved)


def _cost(ground: Ground, effects: Sequence[Float]) -> Float:
    """What each effect costs where it was not looked, all fitted on the working rows with and without it, (k,)."""
    locked, least = ground.locked, np.finfo(float).tiny
    worth = float(locked.sum()) / ground.memory(*effects)
    left = [
        max(float(np.sum(ground.residual(*some)[locked] ** 2)), least)
        for some in (effects, *([*effects[:k], *effects[k + 1 :]] for k in range(len(effects))))
    ]
    return worth * np.log(left[0] / np.array(left[1:]))


def _heard(ground: Ground, torques: Float, k: int, clusters: Clusters) -> tuple[float, float]:
    """Sum of squares of a torque on the locked rows, free of all else, and how many clusters hold it, if evenly."""
    rest = np.hstack([ground.base, np.delete(torques, k, axis=1)])[ground.locked]
    torque = torques[ground.locked, k]
    free = torque - rest @ least_squares(rest, torque)
    _, place = np.unique(clusters.number, return_inverse=True)
    shares = np.bincount(place, weights=free**2)
    return float(shares.sum()), float(shares.sum() ** 2 / max(np.sum(shares**2), np.finfo(float).tiny))


def _of_others(ground: Ground, effects: Sequence[Float], k: int, rng: np.random.Generator) -> tuple[float, float]:
    """One-sided p-value and factor over all cycles of the torque that the other cycles predict for each."""
    columns, every = np.hstack([ground.base, *effects]), np.ones_like(ground.working)
    first = ground.base.shape[1] + sum(effect.shape[1] for effect in effects[:k])
    own = slice(first, first + effects[k].shape[1])
    predicted = np.zeros(len(ground.y))
    for cycle in np.unique(ground.rows.cycle[np.any(effects[k] != 0.0, axis=1)]):
        out = ground.rows.cycle == cycle
        factors = least_squares(columns[~out], ground.y[~out])
        predicted[out] = columns[out, own] @ factors[own]
    # A column each, as on the locked cycles: a search that takes many effects leaves fewer clusters than their columns.
    besides = [e @ f for j, (e, f) in enumerate(zip(effects, _factors(ground, every, effects), strict=True)) if j != k]
    others = np.column_stack([ground.base, *besides])
    factor = float(least_squares(np.column_stack([others, predicted]), ground.y)[-1])
    group = Group(name="effect", shapes=(predicted[:, None],))
    clusters = ground.clusters(every, *effects)
    p = omnibus_test(ground.y, others, [group], clusters.number, rng, remember=clusters.remember).p_value
    return (p / 2.0 if factor > 0.0 else 1.0), factor


def _left(ground: Ground, which: NDArray[np.bool_], *effects: Float) -> float:
    """Sum of squares that the declared model and some columns leave of some rows, fitted there."""
    columns, y = np.hstack([ground.base, *effects])[which], ground.y[which]
    return float(np.sum((y - columns @ least_squares(columns, y)) ** 2))


def _factors(ground: Ground, which: NDArray[np.bool_], effects: Sequence[Float]) -> tuple[Float, ...]:
    """Factors of each effect, fitted together on some rows beside the declared model."""
    factors = least_squares(np.hstack([ground.base, *effects])[which], ground.y[which])
    at = np.cumsum([ground.base.shape[1], *(effect.shape[1] for effect in effects)])
    return tuple(factors[i : i + e.shape[1]] for e, i in zip(effects, at, strict=False))


def _torques(ground: Ground, effects: Sequence[Float]) -> Float:
    """Torque of each effect as fitted on the working rows, free of the declared model there, shape (m, effects).

    A curve that is hardly bent is nearly the line of viscous friction, times a large factor: what is left of it would
    pass for rounding.
    """
    factors, w = _factors(ground, ground.working, effects), ground.working
    torques = [e @ f for e, f in zip(effects, factors, strict=True)]
    return np.column_stack([t - ground.base @ least_squares(ground.base[w], t[w]) for t in torques])


def _one_sided(
    ground: Ground, torques: Float, k: int, clusters: Clusters, rng: np.random.Generator, factor: float
) -> float:
    locked = ground.locked
    base = np.hstack([ground.base, np.delete(torques, k, axis=1)])[locked]
    group = Group(name="effect", shapes=(torques[locked, k : k + 1],))
    p = omnibus_test(ground.y[locked], base, [group], clusters.number, rng, remember=clusters.remember).p_value
    return p / 2.0 if factor > 0.0 else 1.0


def holm(p: Float) -> Float:
    """Family-wise p-values (Holm 1979): the i-th smallest times the number of those not smaller, kept ascending."""
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    adjusted = np.empty_like(stepped)
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def rms_gain(before: float, after: float) -> float:
    """Share of the root mean square that an effect removes, from residual sums of squares before and after."""
    return 1.0 - float(np.sqrt(after / before)) if before > 0 else 0.0
