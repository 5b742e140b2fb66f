"""Put the torques of an instant on the coordinates."""

from friction_audit.compensation.records import Record
from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import backlash, joint_elasticity, presliding
from friction_audit.simulation.mechanics.body import FREE
from friction_audit.simulation.mechanics.friction import (
    cogging_torque,
    holding_level,
    other_torque,
    sliding_level,
    viscous_now,
)

LEAST_LEVEL_NM = 1e-9
"""Bristles divide by the level."""


@compiled()
def load_drive(body: Record, since: float, ahead: float) -> None:
    """Set torques and damping of the drive for an instant ``since`` its tick, ``ahead`` of the present positions."""
    n = body.joints
    for i in range(body.count):
        body.force[i] = 0.0
        for k in range(body.count):
            body.damping[i, k] = 0.0
    for i in range(n):
        torque = body.push[i] + since * (body.push_rate[i] + 0.5 * since * body.push_bend[i])
        for k in range(n):
            torque -= body.stiffness[i, k] * (body.y[k] + ahead * body.v[k])
            body.damping[i, k] = body.drive_damping[i, k]
        body.force[i] = torque


@compiled()
def load_joint(
    joint: Record,
    state: Record,
    events: Float,
    body: Record,
    j: int,
    ahead: float,
    t: float,
    duration: float,
) -> None:
    """Add what acts inside one joint: transmission, friction, the other torques behind the sensor."""
    c = body.inner[j]
    if c != j:
        _load_transmission(joint, body, j, ahead)
    q, dq = body.y[c] + ahead * body.v[c], body.v[c] + ahead * body.a[c]
    body.behind[j] = body.support[j] + other_torque(joint, state, events, q, dq, t)
    if state.driven:
        body.force[j] += cogging_torque(joint, body.y[j] + ahead * body.v[j])
    else:
        body.behind[j] += cogging_torque(joint, q)
    body.force[c] += body.behind[j]
    lagging = joint.hidden.frictional_lag.lag_s != 0.0
    body.viscous[j] = 0.0 if lagging else viscous_now(joint, state, t, duration)
    body.damping[c, c] += body.viscous[j]
    load_friction(joint, state, body, j, ahead, t, duration)


@compiled()
def load_friction(
    joint: Record,
    state: Record,
    body: Record,
    j: int,
    ahead: float,
    t: float,
    duration: float,
) -> None:
    """Set what friction does to one joint, sliding, stuck or free."""
    c = body.inner[j]
    q, dq = body.y[c] + ahead * body.v[c], body.v[c] + ahead * body.a[c]
    mode = body.mode[c]
    if mode == FREE:
        level = sliding_level(joint, state, q, abs(dq), 1.0 if dq >= 0.0 else -1.0, t, duration)
        level = max(level, LEAST_LEVEL_NM)
        body.level[c] = presliding.force_nm(joint.hidden.presliding, state.bristles, joint.coulomb_nm, level, dq)
    elif mode == 0.0:
        for way in range(2):
            sign = 2.0 * way - 1.0
            body.hold[c, way] = holding_level(joint, state, q, sign, t, duration)
            body.slip[c, way] = sliding_level(joint, state, q, 0.0, sign, t, duration)
    else:
        body.level[c] = sliding_level(joint, state, q, max(0.0, dq * mode), mode, t, duration)


@compiled()
def _load_transmission(joint: Record, body: Record, j: int, ahead: float) -> None:
    """Add the spring and the damper, or the flanks, between the two sides of a joint."""
    c = body.inner[j]
    stretch = body.y[c] + ahead * body.v[c] - body.y[j] - ahead * body.v[j]
    engaged = backlash.engaged(joint.hidden.backlash, stretch)
    if engaged == 0.0 and joint.hidden.backlash.gap_rad != 0.0:
        return
    ringing = body.mass[c, c] * body.mass[j, j] / (body.mass[c, c] + body.mass[j, j])
    torque, damping = _transmitted(joint, engaged, ringing)
    closing = body.v[c] + ahead * body.a[c] - body.v[j] - ahead * body.a[j]
    if joint.hidden.backlash.gap_rad != 0.0 and (torque + damping * closing) * engaged < 0.0:
        return  # Flanks that part push no more, and they never pull.
    body.force[c] -= torque
    body.force[j] += torque
    body.damping[c, c] += damping
    body.damping[j, j] += damping
    body.damping[c, j] -= damping
    body.damping[j, c] -= damping


@compiled()
def _transmitted(joint: Record, engaged: float, ringing: float) -> tuple[float, float]:
    """Return spring torque and damping of a transmission twisted beyond its play."""
    elastic, flanks = joint.hidden.joint_elasticity, joint.hidden.backlash
    if elastic.compliance_rad_per_nm != 0.0:
        return joint_elasticity.torque_nm(elastic, engaged), joint_elasticity.damping_nms_per_rad(elastic, ringing)
    return backlash.contact_nm(flanks, engaged), backlash.contact_damping_nms_per_rad(flanks, ringing)
