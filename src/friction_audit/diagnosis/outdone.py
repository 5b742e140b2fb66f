"""Whether a curve over one quantity explains more than the names do: then they are not what it is.

A relative of what is in no catalogue takes a part of it, by chance of its form. Where most is left beside the names a
curve over the right quantity finds it there, though the curve has a dozen numbers to pay for. And where the motion ties
quantities together, as a sinusoid does, the curve takes all that the names took and more: they tell nothing beside it.

Reference: G. E. Mizon, J.-F. Richard, The encompassing principle and its application to testing non-nested hypotheses,
Econometrica 54 (1986) 657.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.alternatives import WRONG_NAME
from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.groups import not_zero
from friction_audit.diagnosis.naming import LEAST_SHARE
from friction_audit.joint_log import Float

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, kw_only=True, slots=True)
class Told:
    """What one curve explains, n_eff ln(RSS without / RSS with) over all cycles.

    Attributes:
        axis: Quantity that it is a function of.
        numbers: How many numbers it has.
        alone: In the place of the names.
        beside: Beside the names.
    """

    axis: str
    numbers: int
    alone: float
    beside: float


def find_outdone(ground: Ground, effects: Sequence[Float], numbers: int, along: Collection[str] = ()) -> str:
    """Say over which quantity a curve explains more than some effects do; empty where none does.

    What speaks for k numbers over all cycles is L - k - k ln(L / k), L = n_eff ln(RSS without / RSS with): twice the
    logarithm of the Bayes factor with the prior that suits them best (George and Foster 2000), so that nothing speaks
    for what brings no more than the k of noise. Either more speaks for a curve beside the names than for them. Or more
    speaks for it in their place, though they are functions of another quantity, they bring no more than chance beside
    it, and it brings more beside them than their formulas may lack.

    Args:
        ground: The joint.
        effects: Columns of all effects on the rows, shape (m, p) each.
        numbers: How many numbers they took, those of shapes too.
        along: Quantities that they are functions of.
    """
    if not effects:
        return ""
    worth = len(ground.y) / ground.memory(*effects)
    explained = _gain(ground, effects, worth)
    curves = list(_curves(ground, effects, worth))
    beside = max(curves, key=lambda told: _speaks(told.beside, told.numbers), default=None)
    if beside and _speaks(beside.beside, beside.numbers) > _speaks(explained, numbers):
        return f"a curve over {beside.axis} explains more beside what was named than that does"
    instead = (told for told in curves if told.axis not in along and _instead(told, explained, numbers))
    best = max(instead, key=lambda told: _speaks(told.alone, told.numbers), default=None)
    return "" if best is None else f"a curve over {best.axis} explains all that what was named does, and more"


def what_speaks(ground: Ground, effects: Sequence[Float], numbers: int, worth: float) -> float:
    """What speaks for some effects together, L - k - k ln(L / k), over all cycles; nothing for none.

    Args:
        ground: The joint.
        effects: Columns of all effects on the rows, shape (m, p) each.
        numbers: How many numbers they took, those of shapes too.
        worth: Number of independent samples that the rows are worth.
    """
    return _speaks(_gain(ground, effects, worth), numbers)


def _gain(ground: Ground, effects: Sequence[Float], worth: float) -> float:
    with_them, without = (Beside(np.hstack([ground.base, *some]), ground.y).without for some in (effects, ()))
    return worth * float(np.log(max(without, TINY) / max(with_them, TINY)))


def _curves(ground: Ground, effects: Sequence[Float], worth: float) -> Iterator[Told]:
    bare, model = Beside(ground.base, ground.y), Beside(np.hstack([ground.base, *effects]), ground.y)
    for curve in ground.curves:
        columns = curve.group.shapes[0]
        alone, beside = (
            worth * float(np.log(max(one.without, TINY) / max(one.fit(columns)[1], TINY))) for one in (bare, model)
        )
        yield Told(axis=curve.axis.name, numbers=int(not_zero(columns).sum()), alone=alone, beside=beside)


def _instead(told: Told, explained: float, numbers: int) -> bool:
    """Whether a curve is what there is, and the names only run alike."""
    from scipy.special import chdtri

    more = _speaks(told.alone, told.numbers) > _speaks(explained, numbers)
    nothing = explained + told.beside - told.alone < chdtri(numbers, WRONG_NAME)
    return bool(more and nothing and told.beside > LEAST_SHARE**2 * explained)


def _speaks(gain: float, numbers: int) -> float:
    return gain - numbers - numbers * float(np.log(gain / numbers)) if gain > numbers > 0 else 0.0
