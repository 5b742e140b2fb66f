"""What is behind the transmission: without an inertia there no spring rings, and no gap strikes."""

from friction_audit.diagnosis.candidate import Baseline
from friction_audit.dynamics.transmission import FarSide


def inertia_behind(baseline: Baseline) -> str | None:
    """An inertia above zero; None, or one sentence that names the motion that would show one."""
    if baseline.inertia_kg_m2 > 0.0:
        return None
    return "the torque shows no inertia: reverse faster, so that the motor's inertia is felt"


def far_side_of(baseline: Baseline) -> FarSide:
    """Inertia and friction of the declared model; friction that would push counts as none."""
    return FarSide(
        inertia_kg_m2=max(baseline.inertia_kg_m2, 0.0),
        coulomb_nm=max(baseline.coulomb_nm, 0.0),
        viscous_nms_per_rad=max(baseline.viscous_nms_per_rad, 0.0),
    )
