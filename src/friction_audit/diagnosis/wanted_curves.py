"""Which curves what a model leaves asks for: those that take more of it than of noise.

Curves over all axes at once take most of what is slow out of slow noise, and of anything else: seventy columns where
the rows are worth a hundred independent ones. What is to be told of the noise, or looked for in it, is told beside
those curves alone that something missing has bent.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.diagnosis.cross_products import cross_products
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.noise import Index, integral_time
from friction_audit.diagnosis.search import search
from friction_audit.joint_log import Float

MOST_ROUNDS = 4
SETTLED = 0.05


def wanted_curves(y: Float, base: Float, curves: Sequence[Group], run: Index) -> Float:
    """Search the curves as effects are searched: at the price that one of them enters noise once in a hundred logs.

    Args:
        y: Response, shape (n,).
        base: Columns that are always in the model, shape (n, b).
        curves: Columns of one shape each.
        run: Number of the unbroken stretch of each row, shape (n,).

    Returns:
        Columns of the curves that enter, shape (n, p).
    """
    products = cross_products(y, base, curves)
    columns, worth = np.zeros((len(y), 0)), 0.0
    for _ in range(MOST_ROUNDS):
        model = np.hstack([base, columns])
        better = len(y) / integral_time(y - model @ np.linalg.lstsq(model, y, rcond=None)[0], run)
        if abs(better - worth) < SETTLED * better:
            break
        worth = better
        names = {chosen.name for chosen in search(products, worth).chosen}
        columns = np.hstack([np.zeros((len(y), 0)), *(curve.shapes[0] for curve in curves if curve.name in names)])
    return columns
