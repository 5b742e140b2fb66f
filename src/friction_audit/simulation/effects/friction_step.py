"""Friction step: from a moment on, friction is another than before."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

ABRUPT, RAMP, SETTLING = range(3)


@dataclass(frozen=True, kw_only=True, slots=True)
class FrictionStep:
    """A change of friction once in a recording.

    Attributes:
        change: Of the Coulomb friction, as a share of it: 0.5 is half as much again.
        viscous_ratio: Change of the viscous friction, as a share of that.
        at_share: When, as a share of the recording.
        length_s: How long a ramp lasts; time constant of settling. [s]
        form: Index into the forms of the effect.
    """

    change: float = 0.0
    viscous_ratio: float = 1.0
    at_share: float = 0.5
    length_s: float = 5.0
    form: int = ABRUPT


@compiled()
def progress(group: Any, t: float, duration: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the share of the change that is done at time t: 0 before the step, 1 at its end."""
    since = t - group.at_share * duration
    if since < 0.0:
        return 0.0
    if group.form == RAMP:
        return float(min(1.0, since / group.length_s))
    if group.form == SETTLING:
        return float(-math.expm1(-since / group.length_s))
    return 1.0


@compiled()
def coulomb_factor(group: Any, t: float, duration: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the Coulomb friction over that before the step, above 0."""
    return float(1.0 + group.change * progress(group, t, duration))


@compiled()
def viscous_factor(group: Any, t: float, duration: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the viscous friction over that before the step, above 0."""
    return float(1.0 + group.change * group.viscous_ratio * progress(group, t, duration))


EFFECT = Effect(
    name="friction_step",
    family="slow and events",
    summary="friction changes once, at a moment of the recording",
    group=FrictionStep,
    strength="change",
    parameters=(
        Parameter(name="change", usual=0.5, meaning="change of Coulomb friction, as a share of it", low=-0.95),
        Parameter(name="viscous_ratio", usual=1.0, meaning="change of viscous friction, as a share of that", high=1.0),
        Parameter(name="at_share", usual=0.5, meaning="when, as a share of the recording", high=1.0),
        Parameter(name="length_s", usual=5.0, meaning="length of the ramp, time constant of settling [s]", low=1e-3),
    ),
    forms=("abrupt", "ramp", "settling"),
)
