"""A short comparison, made once."""

from dataclasses import replace
from functools import cache

from friction_audit.compensation.comparison import METHODS, SCENES, Comparison, compare
from friction_audit.compensation.comparison.methods import Scene

SEEDS = 2
CHOSEN = ("none", "disturbance_observer", "torque_regulation", "energy", "oracle")


def short_joint(duration_s: float = 15.0) -> Scene:
    """Return the joint with few and short trials."""
    joint = SCENES[0]
    plan = replace(joint.plan, tuning_seeds=1, most_values=5, sweeps=1, margin_seeds=1, margin_share=0.7)
    return replace(joint, settings=replace(joint.settings, duration_s=duration_s), plan=plan)


@cache
def compared() -> Comparison:
    """Return a comparison of some methods."""
    return compare(short_joint(), SEEDS, [method for method in METHODS if method.name in CHOSEN])
