"""The Panda that is simulated: published ranges, and what had to be assumed."""

from friction_audit.simulate.settings import JointParameters

READY_RAD = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)
"""The vendor's ready pose."""

# Symmetric Coulomb and viscous friction as identified by Knezevic et al. (2026, CC BY 4.0). Reflected inertias of the
# motors are not published: these are assumptions.
_COULOMB_NM = (0.311, 0.201, 0.427, 0.321, 0.356, 0.498, 0.332)
_VISCOUS_NMS_PER_RAD = (0.075, 0.087, 0.041, 0.045, 0.041, 0.057, 0.031)
_INERTIA_KG_M2 = (0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1)

PANDA_JOINTS = tuple(
    JointParameters(inertia_kg_m2=inertia, coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    for inertia, coulomb, viscous in zip(_INERTIA_KG_M2, _COULOMB_NM, _VISCOUS_NMS_PER_RAD, strict=True)
)
"""Motors and friction of joints 1 to 7."""
