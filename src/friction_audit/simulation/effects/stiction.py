"""Stiction: a joint that rested takes more than its sliding friction to break away, the more the longer it rested."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

SATURATING, LOGARITHMIC, IMMEDIATE = range(3)

LONG_REST_S = 10.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Stiction:
    """Break-away level above the level of slow sliding.

    Attributes:
        excess_nm: After a long rest; of the logarithmic form: after a rest of 10 s. [N m]
        dwell_s: Rest over which it grows. [s]
        form: Index into the forms of the effect.
    """

    excess_nm: float = 0.0
    dwell_s: float = 0.5
    form: int = SATURATING


@compiled()
def excess_nm(group: Any, rest_s: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the break-away level above the sliding level after a rest (not negative). [N m]

    Saturating is Kato, Sato and Matsubayashi (1972) with exponent 1; logarithmic is the ageing of contacts (Rabinowicz
    1958, Dieterich 1972): without a bound, but ten times the rest adds only a fixed amount; immediate is the stick
    level of Karnopp (1985), there from the first moment of rest.
    """
    if group.form == LOGARITHMIC:
        share = math.log1p(rest_s / group.dwell_s) / math.log1p(LONG_REST_S / group.dwell_s)
        return float(group.excess_nm * share)
    if group.form == IMMEDIATE:
        return float(group.excess_nm)
    return float(-group.excess_nm * math.expm1(-rest_s / group.dwell_s))


EFFECT = Effect(
    name="stiction",
    family="velocity",
    summary="break-away takes more than slow sliding, the more the longer the rest",
    group=Stiction,
    strength="excess_nm",
    parameters=(
        Parameter(
            name="excess_nm", usual=0.2, meaning="break-away above sliding after a long rest (logarithmic: 10 s) [N m]"
        ),
        Parameter(name="dwell_s", usual=0.5, meaning="rest over which it grows [s]", low=1e-3),
    ),
    forms=("saturating", "logarithmic", "immediate"),
)
