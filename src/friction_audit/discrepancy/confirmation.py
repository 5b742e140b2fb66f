"""Whether the torque that an effect was fitted to on the working cycles is there on the locked ones."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.omnibus import omnibus_test
from friction_audit.discrepancy.search import Group
from friction_audit.joint_log import Float

LEAST_GAIN = 0.005
"""Smallest gain of the root mean square that is worth a name."""


def confirm(ground: Ground, effects: Sequence[Float], rng: np.random.Generator) -> Float:
    """Family-wise p-value of each effect, from cycles that no choice was made on.

    The torque that the working cycles predict is one column; on the locked cycles its factor is fitted beside the
    declared model and the other effects' torques, and must be above zero (wild cluster bootstrap; Holm's step-down
    over the effects). This has twice the power of asking whether each cycle's sum of squares falls.

    Args:
        ground: The joint.
        effects: Columns of each effect on the rows, shape (m, p) each.
        rng: Source of randomness.
    """
    torques = _torques(ground, effects)
    cluster = ground.clusters(ground.locked, *effects)
    p = [_one_sided(ground, torques, k, cluster, rng) for k in range(len(effects))]
    return holm(np.array(p))


def _torques(ground: Ground, effects: Sequence[Float]) -> Float:
    """Torque of each effect as fitted on the working rows, shape (m, effects)."""
    columns = np.hstack([ground.base, *effects])
    factors = least_squares(columns[ground.working], ground.y[ground.working])
    at = np.cumsum([ground.base.shape[1], *(effect.shape[1] for effect in effects)])
    torques = [e @ factors[i : i + e.shape[1]] for e, i in zip(effects, at, strict=False)]
    return np.asarray(np.column_stack(torques), np.float64)


def _one_sided(ground: Ground, torques: Float, k: int, cluster: NDArray[np.int64], rng: np.random.Generator) -> float:
    locked = ground.locked
    base = np.hstack([ground.base, np.delete(torques, k, axis=1)])[locked]
    own, y = torques[locked, k : k + 1], ground.y[locked]
    group = Group(name="effect", shapes=(own,))
    p = omnibus_test(y, base, [group], cluster, rng).p_value
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
