"""USD for Isaac Sim: a layer with ``PhysxJointAxisAPI`` of the joints, over the user's robot.

The friction coefficient of a rotating axis is per degree in this schema (PhysX multiplies it by 180 / pi).
"""

import re
from collections.abc import Sequence
from math import pi

from friction_audit.export.target import ExportedJoint, Target, number
from friction_audit.export.xml_text import XmlText

NO_IDENTIFIER = re.compile(r"\W|^(?=\d)")  # what USD refuses in the name of a prim
AXIS = "physxJointAxis:angular"


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write a layer in text form: sublayer or reference it, and put the joints under their own scope."""
    lines = ["#usda 1.0", "(", '    defaultPrim = "joints"', ")", "", 'over "joints"', "{"]
    for joint in joints:
        values = {
            "staticFrictionEffort": joint.static_nm,
            "dynamicFrictionEffort": joint.fitted.coulomb_nm,
            "viscousFrictionCoefficient": joint.fitted.viscous_nms_per_rad * pi / 180.0,
        }
        inertia = joint.law.inertia_kg_m2
        values |= {} if inertia is None else {"armature": inertia}
        lines += [
            f'    over "{NO_IDENTIFIER.sub("_", joint.name)}" (',
            '        prepend apiSchemas = ["PhysxJointAxisAPI:angular"]',
            "    )",
            "    {",
            *(f"        float {AXIS}:{key} = {number(value)}" for key, value in values.items()),
            "    }",
        ]
    return "\n".join((*lines, "}", "")).encode()


TARGET = Target(
    name="usd",
    suffix=".usda",
    summary="PhysX joint friction and armature of Isaac Sim as a USD layer",
    highest_power=1,
    write=write,
    armature=True,
)
