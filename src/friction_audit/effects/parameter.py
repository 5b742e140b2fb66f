"""A number of an effect: name, unit, meaning, bounds. Imports nothing, so that the simulator may read it."""

from dataclasses import KW_ONLY, dataclass
from math import inf, isfinite


@dataclass(frozen=True, slots=True)
class Parameter:
    """A coefficient or a nonlinear parameter.

    Attributes:
        name: Its name with the unit as suffix, e.g. ``coulomb_nm``; unique over all effects but for ``far_share``.
        unit: The unit, as people write it.
        meaning: One line.
        lower: Smallest value that makes sense.
        upper: Largest value that makes sense.
        whole: True for a choice by number, between which there is nothing.
        optional: True for a number that a file of a model may lack.
        default: What an optional number is where it is lacking.
    """

    name: str
    unit: str
    meaning: str
    _: KW_ONLY
    lower: float = -inf
    upper: float = inf
    whole: bool = False
    optional: bool = False
    default: float = 0.0

    def allows(self, value: float) -> bool:
        """Return True for a finite value within the bounds."""
        return isfinite(value) and self.lower <= value <= self.upper
