"""A number of an effect: name, unit, meaning, bounds. Imports nothing, so that the simulator may read it."""

from dataclasses import KW_ONLY, dataclass
from math import inf, isfinite
from typing import Self


@dataclass(frozen=True, slots=True)
class Parameter:
    """A coefficient or a nonlinear parameter."""

    name: str  # with the unit as suffix, e.g. ``coulomb_nm``; unique over all effects but for ``far_share``
    unit: str  # as people write it
    meaning: str  # one line
    _: KW_ONLY
    lower: float = -inf  # smallest value that makes sense
    upper: float = inf  # largest value that makes sense
    whole: bool = False  # True for a choice by number, between which there is nothing
    jumps: bool = False  # True for one at whose value the torque jumps
    optional: bool = False  # True for a number that a file of a model may lack
    default: float = 0.0  # what an optional number is where it is lacking

    @classmethod
    def choice(cls, name: str, meaning: str, lower: float, upper: float = inf, *, optional: bool = False) -> Self:
        """Return a choice by number."""
        return cls(name, "1", meaning, lower=lower, upper=upper, whole=True, optional=optional)

    def allows(self, value: float) -> bool:
        """Return True for a finite value within the bounds."""
        return isfinite(value) and self.lower <= value <= self.upper
