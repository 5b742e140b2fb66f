"""Interaction -> EnergyCycles: segmentation and energy sums."""

from typing import TYPE_CHECKING

from friction_audit.preprocessing.interaction import Caution, Interaction, SignEvidence, TorqueChoice
from friction_audit.preprocessing.interaction_torque import extract_interaction

if TYPE_CHECKING:
    from friction_audit.preprocessing.energy_cycles import EnergyCycles
    from friction_audit.preprocessing.settings import CycleSettings


def segment_cycles(interaction: "Interaction", settings: "CycleSettings") -> "EnergyCycles":
    """Find the energy cycles of every joint; see :mod:`friction_audit.preprocessing.segmentation`."""
    from friction_audit.preprocessing.segmentation import segment_cycles as segment

    return segment(interaction, settings)


__all__ = ["Caution", "Interaction", "SignEvidence", "TorqueChoice", "extract_interaction"]
