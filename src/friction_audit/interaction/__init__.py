"""JointLog -> Interaction: the torque at the friction port, its sign and its provenance."""

from friction_audit.interaction.extract import extract_interaction
from friction_audit.interaction.interaction import Caution, Interaction, SignEvidence, TorqueChoice

__all__ = ["Caution", "Interaction", "SignEvidence", "TorqueChoice", "extract_interaction"]
