"""The recorded motion, and the torque the person would have needed: closed over the torque, not over the motion."""

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.compensators.kind import JOINT_MODEL
from friction_audit.replay.feed_forward import tell_friction
from friction_audit.replay.port import Port
from friction_audit.replay.tally import count_energy
from friction_audit.replay.tick import Control, interval, tick, write_down


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
    settings, memory, tally, feed, cuts, course, rows = control
    t, dq, torque, logged = port
    before = needed_before = 0.0
    for i in range(len(t)):
        dt = interval(t, i)
        total = torque[i] + logged[i] if len(logged) > 0 else torque[i]
        needed = total - memory.u_nm
        write_down(course, i, needed, memory)
        if i > 0:
            moved = 0.5 * (dq[i - 1] + dq[i]) * dt
            friction, exchange = 0.5 * (before + total) * moved, 0.5 * (needed_before + needed) * moved
            count_energy(tally, settings, friction, exchange, moved, dt)
        if settings.kind == JOINT_MODEL:
            tell_friction(memory, feed, q[i], dq[i], i)
        if not tick(settings, memory, tally, i, dt, dq[i], needed, cuts[i] if len(cuts) > 1 else cuts[0], rows):
            return i
        before, needed_before = total, needed
    return len(t)
