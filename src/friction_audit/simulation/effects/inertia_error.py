"""Inertia error: behind the sensor turns more, or less, than the model of the joint says."""

import math
from dataclasses import dataclass

from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class InertiaError:
    """Inertia behind the sensor that the model does not know.

    Attributes:
        extra_kg_m2: True inertia less the model's, reflected to the joint. [kg m^2]
    """

    extra_kg_m2: float = 0.0


EFFECT = Effect(
    name="inertia_error",
    family="structure",
    summary="the reflected inertia is not that of the model",
    group=InertiaError,
    strength="extra_kg_m2",
    parameters=(
        Parameter(
            name="extra_kg_m2", usual=0.1, meaning="true inertia less the model's, reflected [kg m^2]", low=-math.inf
        ),
    ),
)
