"""The number of a shape on which the misfit has many valleys: which of many values leave least.

When a play is crossed a moment sooner its flanks ring out of step, so that the misfit goes up and down with the width.
No descent finds the lowest valley, and no grid over all widths is fine enough. So many values are tried near one, each
with the best of the other numbers of the shape.
"""

from collections.abc import Iterable

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal

FARTHEST = 1.8
"""Values are tried from so many times less to so many times more than the one that was found."""
VALUES = 21

Valleys = dict[float, tuple[float, Nonlinear]]
"""What is left of the rows' squares by the best shape with each value of a number, and that shape."""


def around(value: float) -> list[float]:
    """Values to either side of one above zero."""
    return [float(v) for v in value * np.geomspace(1.0 / FARTHEST, FARTHEST, VALUES)]


def valleys(
    candidate: Effect, shape: Nonlinear, values: Iterable[float], ground: Ground, baseline: Nominal, beside: Beside
) -> Valleys:
    """Try values of the rugged number of a shape, each with those of other numbers that go with it.

    Args:
        candidate: The effect.
        shape: What all others of its numbers are.
        values: Of the rugged number.
        ground: The joint.
        baseline: What columns may lean on.
        beside: The rows of the ground with all other columns of the model.
    """
    name, best = candidate.multimodal, Valleys()
    tried = [{**shape, name: value, **others} for value in values for others in ({}, *candidate.multimodal_with)]
    for place, columns in candidate.regressors(ground.data, baseline, tried):
        one = tried[place]
        factors, left = beside.fit(ground.rows.of(columns))
        misfit = left if candidate.admissible(factors, one) else beside.without
        if one[name] not in best or misfit < best[one[name]][0]:
            best[one[name]] = misfit, one
    return best
