"""Where transmissions stand when a recording begins: twisted by the load that they carry."""

import math

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.records import Record
from friction_audit.simulate.effects import backlash, joint_elasticity

HALVINGS = 60
"""So often an interval is halved until nothing is left of it."""


@compiled()
def _twist(joint: Record, load_nm: float) -> float:
    """Return the twist at which a transmission carries a load (bisection). [rad]"""
    elastic, flanks = joint.hidden.joint_elasticity, joint.hidden.backlash
    soft = elastic.compliance_rad_per_nm != 0.0
    # A hardening gear is at most twice as soft as its compliance says.
    low, high = 0.0, 2.0 * abs(load_nm) * (elastic.compliance_rad_per_nm + flanks.contact_compliance_rad_per_nm)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        torque = joint_elasticity.torque_nm(elastic, middle) if soft else backlash.contact_nm(flanks, middle)
        if torque < abs(load_nm):
            low = middle
        else:
            high = middle
    return float(math.copysign(0.5 * (low + high + flanks.gap_rad), load_nm))


@compiled()
def settle(joints: Record, body: Record, load_nm: Float) -> None:
    """Let the inner sides stand where the transmissions carry a load; without one, in the middle of their play.

    Args:
        joints: Records of the joints, shape (n,).
        body: Coordinates, at rest; changed.
        load_nm: Torque from the outer side that the inner one bears, shape (n,). [N m]
    """
    for j in range(len(joints)):
        c = body.inner[j]
        if c != j and load_nm[j] != 0.0:
            body.y[c] = body.y[j] + _twist(joints[j], load_nm[j])
