"""Stiction: a joint that rested takes more than its sliding friction to break away, the more the longer it rested."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import HiddenEffect, number, strength

SATURATING, LOGARITHMIC, IMMEDIATE = range(3)

LONG_REST_S = 10.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Stiction(HiddenEffect):
    """Break-away level above the level of slow sliding."""

    summary = "break-away takes more than slow sliding, the more the longer the rest"
    forms = ("saturating", "logarithmic", "immediate")

    excess_nm: float = strength(
        0.2, "break-away above sliding after a long rest (logarithmic: 10 s)", like="breakaway_excess_nm"
    )
    dwell_s: float = number(0.5, "rest over which it grows", like="ageing_s")
    form: int = SATURATING


@compiled()
def excess_nm(group: Record, rest_s: float) -> float:
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
