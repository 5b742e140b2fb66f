"""The compensation methods side by side: same operator, same arm, same noise, same seeds."""

from friction_audit.compensation.comparison.experiment import compare
from friction_audit.compensation.comparison.methods import METHODS, SCENES
from friction_audit.compensation.comparison.result import Comparison

__all__ = ["METHODS", "SCENES", "Comparison", "compare"]
