"""A toy candidate as a search would have found it."""

from collections.abc import Mapping

from friction_audit.diagnosis.alternatives import Naming
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Found
from friction_audit.effects.effect import Effect


def found_effect(ground: Ground, candidate: Effect, shape: Mapping[str, float]) -> Found:
    """Return the candidate of this shape, without rivals."""
    return Found(
        candidate=candidate,
        shape=shape,
        columns=ground.rows.of(candidate.regressor(ground.data, ground.baseline(), shape)),
        naming=Naming(name=candidate.name, rivals=(), alternatives=()),
        p_value=0.01,
    )
