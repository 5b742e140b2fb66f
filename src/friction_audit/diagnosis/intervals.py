"""Values of all numbers with 95 % intervals, by a cluster jackknife over cycles.

The model is linearised in its nonlinear parameters at their estimate; leaving out one cycle at a time moves all numbers
together (A. C. Cameron, D. L. Miller, Journal of Human Resources 50 (2015) 317). A coefficient that follows from the
nonlinear parameters, as a compliance from the stiffness, has their interval. A nonlinear parameter whose interval spans
a decade, or its grid, is not identifiable from the log.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.gram import Gram, Training
from friction_audit.diagnosis.nonlinear import DIFFERENCE, Scale
from friction_audit.diagnosis.selection import split
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

CONFIDENCE = 0.95
WIDEST = float(np.log(10.0)) / 2.0  # half of an interval in the logarithm of a parameter
WIDEST_STEPS = 4.0  # half of an interval of one that may be zero, in steps of its grid
PRIOR_STEPS = 10.0  # standard deviation of a parameter in steps of its grid, so that the solve has an answer
REACHES = (4 * DIFFERENCE, 1.0)  # in steps of the grid; moments within a rest, and impacts, need the longer one


class Estimates(NamedTuple):
    """Numbers with intervals."""

    nominal: dict[str, Coefficient]  # of the nominal columns as fitted together with the effects, by name
    effects: tuple[dict[str, Coefficient], ...]  # of each effect, by name: coefficients, then nonlinear parameters
    not_identifiable: tuple[tuple[str, ...], ...]  # of each effect, parameters with infinite intervals


def of(gram: Gram, dictionary: Dictionary, active: Sequence[Block], baseline: Nominal) -> Estimates:
    """Intervals of the nominal model and of all effects."""
    fit = Training(gram).fit(active)
    scales = [Scale(dictionary, block) for block in active]
    base, free, slopes = gram.base[fit.kept], [], []
    for block, scale, c in zip(active, scales, split(fit, active), strict=True):
        slopes.append(_slopes(gram, dictionary, block, scale, c, baseline))
        if not block.effect.follows:
            free.append(gram.of(block))
    rows = np.vstack([base, *free, *slopes])
    steps = sum(len(one) for one in slopes)
    prior = np.zeros(len(rows))
    prior[: len(base)], prior[len(rows) - steps :] = gram.precision[fit.kept], PRIOR_STEPS**-2.0
    half = _jackknife(gram, rows, prior)
    nominal = {name: _around(fit.coefficients[k], half[k]) for k, name in enumerate(gram.problem.nominal.names)}
    at, step_at = len(base), len(rows) - steps
    effects, missing = [], []
    for block, scale, c in zip(active, scales, split(fit, active), strict=True):
        fixed = {n: Coefficient(value=v, low=v, high=v) for n, v in block.shape.items() if n not in scale.names}
        nonlinear, unknown = _free(block, scale, half[step_at : step_at + len(scale.names)])
        step_at += len(scale.names)
        named = zip(block.effect.coefficients, block.there, strict=False)
        labels = [parameter.name for parameter, there in named if there]
        if block.effect.follows:
            numbers = {labels[0]: _following(block, nonlinear)}
            unknown = (*unknown, *(name for name, one in numbers.items() if not np.isfinite(one.high)))
        else:
            numbers = {name: _around(c[k], half[at + k]) for k, name in enumerate(labels)}
            at += block.p
        effects.append(numbers | {n: (nonlinear | fixed)[n] for n in block.shape})
        missing.append(unknown)
    return Estimates(nominal=nominal, effects=tuple(effects), not_identifiable=tuple(missing))


def _following(block: Block, nonlinear: dict[str, Coefficient]) -> Coefficient:
    """A coefficient that follows from the nonlinear parameters, from one end of their intervals to the other."""
    ends = [block.shape | {name: getattr(c, end) for name, c in nonlinear.items()} for end in ("low", "high")]
    value, *limits = (block.effect.coefficient_of(at) for at in (block.shape, *ends))
    known = min(limits) <= value <= max(limits)  # one over an infinite stiffness is not between them
    return Coefficient(value=value, low=min(limits) if known else -np.inf, high=max(limits) if known else np.inf)


def _around(value: float, half: float) -> Coefficient:
    return Coefficient(value=float(value), low=float(value - half), high=float(value + half))


def _free(block: Block, scale: Scale, half: Float) -> tuple[dict[str, Coefficient], tuple[str, ...]]:
    """Nonlinear parameters with their intervals, and the names of those that are not identifiable."""
    free, unknown = {}, []
    for k, name in enumerate(scale.names):
        value, reach = block.shape[name], float(half[k] * scale.unit[k])
        wide = reach > WIDEST if scale.log[k] else half[k] > WIDEST_STEPS
        if wide or not np.isfinite(reach):
            unknown.append(name)
            free[name] = Coefficient(value=value, low=-np.inf, high=np.inf)
        elif scale.log[k]:
            free[name] = Coefficient(value=value, low=float(value * np.exp(-reach)), high=float(value * np.exp(reach)))
        else:
            free[name] = _around(value, reach)
    return free, tuple(unknown)


def _slopes(
    gram: Gram, dictionary: Dictionary, block: Block, scale: Scale, coefficients: Float, baseline: Nominal
) -> Float:
    """Whitened derivatives of an effect's torque with respect to its nonlinear parameters, shape (k, m)."""
    out = np.empty((len(scale.names), len(gram.y)))
    for k, unit in enumerate(np.eye(len(scale.names))):
        for reach in REACHES[-1:] if block.effect.transmits else REACHES:
            ends = [scale.at(x * unit) for x in (reach, -reach)]
            if block.effect.follows:
                torques = dictionary.torques_at(block, ends, [baseline] * 2)
            else:
                torques = np.stack([coefficients @ dictionary.columns_at(block, one, baseline) for one in ends])
            out[k] = gram.whiten(torques[0] - torques[1])[0] / (2.0 * reach)
            if out[k] @ out[k] > PRIOR_STEPS**-2.0:
                break
    return out


def _jackknife(gram: Gram, rows: Float, prior: Float) -> Float:
    """Half widths of the intervals, shape (k,).

    The variance is CV3, around the full estimate (J. G. MacKinnon, M. O. Nielsen, M. D. Webb, Journal of Econometrics
    232 (2023) 272); Student's t has the effective number of cycles (A. V. Carter, K. T. Schnepel, D. G. Steigerwald,
    Review of Economics and Statistics 99 (2017) 698).
    """
    from scipy.special import stdtrit

    cycle = gram.problem.samples.cycle[gram.order]
    order = np.argsort(cycle, kind="stable")
    ends = np.append(np.flatnonzero(np.diff(cycle[order], prepend=cycle[order][0] - 1)), len(cycle))
    scale = np.sqrt(np.maximum(np.sum(rows**2, axis=1) + prior, 1e-300))
    scaled, y = rows[:, order] / scale[:, None], gram.y[order]
    grams = np.stack([scaled[:, a:b] @ scaled[:, a:b].T for a, b in pairwise(ends.tolist())])
    rights = np.stack([scaled[:, a:b] @ y[a:b] for a, b in pairwise(ends.tolist())])
    whole = grams.sum(axis=0) + np.diag(prior / scale**2)
    without = np.linalg.pinv(whole - grams, rcond=1e-12, hermitian=True) @ (rights.sum(axis=0) - rights)[:, :, None]
    inverse = np.linalg.pinv(whole, rcond=1e-12, hermitian=True)
    spread = (without[:, :, 0] - inverse @ rights.sum(axis=0)) / scale
    m = len(grams)
    # Effective number of cycles of each number: a step, or the time of a warm-up, rests on a few of them.
    parts = np.einsum("ka,gab,bk->gk", inverse, grams, inverse)
    cycles = np.sum(parts, axis=0) ** 2 / np.maximum(np.sum(parts**2, axis=0), 1e-300)
    # What the prior alone holds does not move without a cycle: its width is that of the prior.
    held = (np.diag(inverse) / scale**2) ** 2 * prior
    variance = (m - 1) / m * np.sum(spread**2, axis=0) + held
    return np.asarray(stdtrit(np.maximum(cycles - 1.0, 1.0), 0.5 + CONFIDENCE / 2) * np.sqrt(variance))
