"""A recorded motion with all that a term may lean on, and typical numbers of every term."""

import numpy as np

from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.parameter import Parameter

TYPICAL = {"presliding": (0.3, 0.005, 1.0, 0.005)}
"""Numbers of terms whose bounds are far apart: bristles with the damping of the middle would be a damper."""


def typical(parameter: Parameter) -> float:
    """A number well within the bounds: the geometric middle of positive ones, else a little above the lowest."""
    low, high = parameter.lower, parameter.upper
    if low > 0.0 and np.isfinite(high):
        return float(np.sqrt(low * high))
    if np.isfinite(low) and np.isfinite(high):
        return low + 0.6 * (high - low)
    return low + 0.3 if np.isfinite(low) else 0.3


def typical_term(term: Effect) -> FittedTerm:
    """A term with typical numbers."""
    values = TYPICAL.get(term.name, tuple(typical(parameter) for parameter in term.parameters))
    return FittedTerm(term.name, values)
