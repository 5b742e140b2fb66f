"""Isaac Lab: the keyword arguments of an actuator's configuration, in SI units, as a Python module."""

from collections.abc import Sequence

from friction_audit import __version__
from friction_audit.export.target import ExportedJoint, Target, number
from friction_audit.export.xml_text import XmlText

HEAD = f'''"""Joint friction by friction-audit {__version__}, for the actuators of Isaac Lab.

    from joint_friction import FRICTION
    ImplicitActuatorCfg(joint_names_expr=list(FRICTION["friction"]), stiffness=..., damping=..., **FRICTION)

friction: static, N m; dynamic_friction: Coulomb, N m; viscous_friction: N m s/rad; armature: kg m^2.
"""
'''


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write one dictionary per argument, by joint."""
    values = {
        "friction": {j.name: j.static_nm for j in joints},
        "dynamic_friction": {j.name: j.fitted.coulomb_nm for j in joints},
        "viscous_friction": {j.name: j.fitted.viscous_nms_per_rad for j in joints},
        "armature": {j.name: j.law.inertia_kg_m2 for j in joints if j.law.inertia_kg_m2 is not None},
    }
    lines = [HEAD, "FRICTION = {"]
    for key, by_joint in values.items():
        if by_joint:
            inside = ", ".join(f"{name!r}: {number(value)}" for name, value in by_joint.items())
            lines.append(f"    {key!r}: {{{inside}}},")
    return "\n".join((*lines, "}", "")).encode()


TARGET = Target(
    name="isaac-lab",
    suffix=".py",
    summary="static, dynamic and viscous friction and armature for the actuators of Isaac Lab",
    highest_power=1,
    write=write,
    armature=True,
)
