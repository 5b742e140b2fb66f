"""Whether a curve over one quantity explains more beside the names than all of them do: then they are not what it is.

A relative of what is in no catalogue takes a part of it, by chance of its form; most is left. Where it is left beside
the names a curve over the right quantity finds it, though the curve has a dozen numbers to pay for.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.discrepancy.beside import Beside
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.search import not_zero
from friction_audit.joint_log import Float


def find_outdone(ground: Ground, effects: Sequence[Float], numbers: int) -> str:
    """Say over which quantity a curve explains more beside some effects than they do; empty where none does.

    What speaks for k numbers over all cycles is L - k - k ln(L / k), L = n_eff ln(RSS without / RSS with): twice the
    logarithm of the Bayes factor with the prior that suits them best (George and Foster 2000), so that nothing speaks
    for what brings no more than the k of noise.

    Args:
        ground: The joint.
        effects: Columns of all effects on the rows, shape (m, p) each.
        numbers: How many numbers they took, those of shapes too.
    """
    if not effects:
        return ""
    worth, least = len(ground.y) / ground.memory(*effects), float(np.finfo(float).tiny)
    model = Beside(np.hstack([ground.base, *effects]), ground.y)
    rest = max(model.without, least)
    explained = worth * np.log(max(Beside(ground.base, ground.y).without, least) / rest)
    told = []
    for curve in ground.curves:
        columns = curve.group.shapes[0]
        more = worth * np.log(rest / max(model.fit(columns)[1], least))
        told.append((_speaks(more, int(not_zero(columns).sum())), curve.axis.name))
    most, axis = max(told, default=(0.0, ""))
    if most <= _speaks(explained, numbers):
        return ""
    return f"a curve over {axis} explains more beside what was named than that does"


def _speaks(gain: float, numbers: int) -> float:
    return gain - numbers - numbers * float(np.log(gain / numbers)) if gain > numbers else 0.0
