"""Effects that a synthetic log can hide: one module each."""

from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.effects.hidden import EFFECTS, Hidden

__all__ = ["EFFECTS", "Hidden", "HiddenEffect"]
