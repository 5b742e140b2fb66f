"""Whether a log tells of an inertia behind the transmission: without one no spring rings, and no gap strikes."""

from friction_audit.discrepancy.candidate import Baseline


def inertia_behind(baseline: Baseline) -> str | None:
    """An inertia above zero; None, or one sentence that names the motion that would show one."""
    if baseline.inertia_kg_m2 > 0.0:
        return None
    return "the torque shows no inertia: reverse faster, so that the motor's inertia is felt"
