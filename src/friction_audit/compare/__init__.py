"""The compensation methods side by side: same operator, same arm, same noise, same seeds."""

from friction_audit.compare.experiment import compare
from friction_audit.compare.methods import METHODS
from friction_audit.compare.result import Comparison
from friction_audit.compare.scene import SCENES

__all__ = ["METHODS", "SCENES", "Comparison", "compare"]
