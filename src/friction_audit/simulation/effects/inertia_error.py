"""Inertia error: behind the sensor turns more, or less, than the model of the joint says."""

from dataclasses import dataclass

from friction_audit.simulation.effects.effect import HiddenEffect, strength


@dataclass(frozen=True, kw_only=True, slots=True)
class InertiaError(HiddenEffect):
    """Inertia behind the sensor that the model does not know."""

    summary = "the reflected inertia is not that of the model"
    same_law = ""

    extra_kg_m2: float = strength(0.1, "true inertia less the model's, reflected", like="extra_inertia_kg_m2")
