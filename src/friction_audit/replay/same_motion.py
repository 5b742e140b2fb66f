"""The recorded motion, and the torque the person would have needed: closed over the torque, not over the motion."""

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.port import Port
from friction_audit.replay.records import Record
from friction_audit.replay.tally import count_energy
from friction_audit.replay.tick import Control, interval, tick


@compiled()
def run_same_motion(control: Control, port: Port, q: Float) -> int:
    """Run a compensator along a recording; return the number of samples, fewer than n once it has diverged.

    The total torque S = F_m + u that drives the inner side in the recording stays. A compensator that gives u' instead
    leaves F' = S - u' to the person, which is what the compensator then measures.

    Args:
        control: The compensator and what it is written into.
        port: The recording.
        q: Position, shape (n,), or empty where the compensator has no use for it. [rad]
    """
    before = needed_before = 0.0
    for i in range(len(port.t)):
        dt, total = interval(port.t, i), total_at(port, i)
        needed = total - control.memory.u_nm
        if i > 0:
            count_along(control.tally, control.settings, port, i, (before, total), (needed_before, needed))
        if not tick(control, i, dt, q[i] if len(q) > 0 else 0.0, port.dq[i], needed):
            return i
        before, needed_before = total, needed
    return len(port.t)


@compiled()
def total_at(port: Port, i: int) -> float:
    """Return the torque S = F_m + u at a sample. [N m]"""
    return float(port.torque[i] + port.logged[i] if len(port.logged) > 0 else port.torque[i])


@compiled()
def count_along(
    tally: Record, settings: Record, port: Port, i: int, total: tuple[float, float], needed: tuple[float, float]
) -> None:
    """Add the interval up to sample i, at whose ends the torque was this in all, and this from the person. [N m]"""
    dt = port.t[i] - port.t[i - 1]
    moved = 0.5 * (port.dq[i - 1] + port.dq[i]) * dt
    friction, exchange = 0.5 * (total[0] + total[1]) * moved, 0.5 * (needed[0] + needed[1]) * moved
    count_energy(tally, settings, friction, exchange, moved, dt)
