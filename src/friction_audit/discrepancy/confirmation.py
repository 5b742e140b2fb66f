"""Whether the torque that an effect was fitted to on the working cycles is there on the locked ones."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.ground import Clusters, Ground
from friction_audit.discrepancy.omnibus import omnibus_test
from friction_audit.discrepancy.search import Group
from friction_audit.joint_log import Float

LEAST_GAIN = 0.005
"""Smallest gain of the root mean square that is worth a name: that of an effect of a tenth of what is left."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Confirmed:
    """What locked cycles say of each effect; k effects.

    Attributes:
        p_value: Family-wise p-value, shape (k,).
        gain: Share of the root mean square that the effect takes away, shape (k,).
        size: Root mean square of its torque free of all else, shape (k,). [N m]
    """

    p_value: Float
    gain: Float
    size: Float


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
    torques = _torques(ground, effects)
    clusters = ground.clusters(ground.locked, *effects)
    p = [_one_sided(ground, torques, k, clusters, rng) for k in range(len(effects))]
    after = _left(ground, torques)
    before = np.array([_left(ground, np.delete(torques, k, axis=1)) for k in range(len(effects))])
    return Confirmed(
        p_value=holm(np.array(p)),
        gain=np.array([rms_gain(one, after) for one in before]),
        size=np.sqrt(np.maximum(before - after, 0.0) / ground.locked.sum()),
    )


def _left(ground: Ground, torques: Float) -> float:
    """Sum of squares that the declared model and some torques leave of the locked rows, fitted there."""
    columns, y = np.hstack([ground.base, torques])[ground.locked], ground.y[ground.locked]
    return float(np.sum((y - columns @ least_squares(columns, y)) ** 2))


def _torques(ground: Ground, effects: Sequence[Float]) -> Float:
    """Torque of each effect as fitted on the working rows, shape (m, effects)."""
    columns = np.hstack([ground.base, *effects])
    factors = least_squares(columns[ground.working], ground.y[ground.working])
    at = np.cumsum([ground.base.shape[1], *(effect.shape[1] for effect in effects)])
    torques = [e @ factors[i : i + e.shape[1]] for e, i in zip(effects, at, strict=False)]
    return np.asarray(np.column_stack(torques), np.float64)


def _one_sided(ground: Ground, torques: Float, k: int, clusters: Clusters, rng: np.random.Generator) -> float:
    locked = ground.locked
    base = np.hstack([ground.base, np.delete(torques, k, axis=1)])[locked]
    own, y = torques[locked, k : k + 1], ground.y[locked]
    group = Group(name="effect", shapes=(own,))
    p = omnibus_test(y, base, [group], clusters.number, rng, remember=clusters.remember).p_value
    factor = least_squares(np.hstack([base, own]), y)[-1]
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
