"""Interaction -> EnergyCycles: segmentation and energy sums."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from friction_audit.cycles.energy_cycles import EnergyCycles
    from friction_audit.cycles.settings import CycleSettings
    from friction_audit.interaction.interaction import Interaction


def segment_cycles(interaction: "Interaction", settings: "CycleSettings") -> "EnergyCycles":
    """Find the energy cycles of every joint; see :mod:`friction_audit.cycles.segment`."""
    from friction_audit.cycles.segment import segment_cycles as segment

    return segment(interaction, settings)
