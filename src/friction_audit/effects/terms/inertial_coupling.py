"""Torque that a joint takes because others accelerate.

Where the arm's model is known, a share of its inertial torque M(q) ddq + c(q, dq), or what an unknown body on the last
link adds to it (Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986). Where it is not, or for motors whose
rotors turn with other joints (De Luca, Book, Robots with flexible elements, 2016), accelerations and squared speeds
of the others, with constant factors.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import INERTIAL_PARAMETERS, Motion, Others
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

BEFORE, AFTER, BOTH, ALL, MODEL, TIP = range(6)
"""Values of the source."""
JOINTS = 7
"""So many joints can be told apart; accelerations of more are not looked at."""
INERTIAL = ("mass", "moment_x", "moment_y", "moment_z", "xx", "xy", "yy", "xz", "yz", "zz")
UNITS = ("kg", "kg_m", "kg_m", "kg_m") + ("kg_m2",) * 6


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return the columns of one source of the torque; those of the others are zero."""
    source = round(shape[0])
    columns = np.zeros((len(TERM.coefficients), len(motion.t))).T  # one behind the other in memory
    rigid = motion.rigid
    if source <= ALL:
        if motion.others is None:
            return columns
        meant = list(_meant(source, motion.others))
        columns[:, meant] = motion.others.ddq[:, meant]
        if source == ALL:
            columns[:, [JOINTS + joint for joint in meant]] = motion.others.dq[:, meant] ** 2
    elif rigid is not None and rigid.inertial is not None and rigid.tip is not None:
        columns[:, 2 * JOINTS] = rigid.at(motion.t, rigid.inertial)
        if source == TIP:
            columns[:, -INERTIAL_PARAMETERS:] = rigid.at(motion.t, rigid.tip)
    return columns


def _meant(source: int, others: Others) -> range | tuple[int, ...]:
    joint, joints = others.joint, min(others.ddq.shape[1], JOINTS)
    wanted = {BEFORE: (joint - 1,), AFTER: (joint + 1,), BOTH: (joint - 1, joint + 1)}
    return tuple(k for k in wanted.get(source, range(joints)) if 0 <= k < joints and k != joint)


TERM = Term(
    name="inertial_coupling",
    label="other joints shake this one",
    coefficients=(
        *(
            Parameter(
                name=f"coupling_to_joint{k}_kg_m2", unit="kg m^2", meaning=f"torque per acceleration of joint {k}"
            )
            for k in range(1, JOINTS + 1)
        ),
        *(
            Parameter(
                name=f"coupling_to_speed{k}_kg_m2", unit="kg m^2", meaning=f"torque per squared speed of joint {k}"
            )
            for k in range(1, JOINTS + 1)
        ),
        Parameter(name="inertial_torque_share", unit="1", meaning="share of the model's inertial torque"),
        *(
            Parameter(name=f"tip_{name}_{unit}", unit=unit.replace("_", " "), meaning=f"of the last link, {name}")
            for name, unit in zip(INERTIAL, UNITS, strict=True)
        ),
    ),
    nonlinear=(
        Parameter(
            name="coupling_source",
            unit="1",
            meaning="0 joint before, 1 after, 2 both, 3 all joints, 4 model of the arm, 5 with its last link",
            lower=BEFORE,
            upper=TIP,
            whole=True,
        ),
    ),
    basis=basis,
)
