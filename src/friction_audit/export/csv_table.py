"""A table of the coefficients, one row per joint."""

from collections.abc import Sequence

from friction_audit.export.target import ExportedJoint, Target
from friction_audit.export.xml_text import XmlText


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write the table."""
    import pandas as pd

    rows = [
        {
            "joint": joint.law.joint,
            "name": joint.name,
            "static_nm": joint.static_nm,
            "coulomb_nm": joint.fitted.coulomb_nm,
            "viscous_nms_per_rad": joint.fitted.viscous_nms_per_rad,
            "inertia_kg_m2": joint.law.inertia_kg_m2,
            "error_nm": joint.fitted.error_nm,
        }
        for joint in joints
    ]
    return pd.DataFrame(rows).to_csv(index=False, lineterminator="\n").encode()


TARGET = Target(
    name="csv",
    suffix=".csv",
    summary="table of static, Coulomb and viscous friction",
    highest_power=1,
    write=write,
    armature=True,
)
