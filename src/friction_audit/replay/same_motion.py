"""The recorded motion, and the torque the person would have needed: closed over the torque, not over the motion."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.kernels import step
from friction_audit.replay.port import Course, Port
from friction_audit.replay.records import Record
from friction_audit.replay.tally import close_row, count_energy, count_tick


@compiled()
def run_same_motion(
    settings: Record, memory: Record, tally: Record, port: Port, cuts: NDArray[np.int64], course: Course, rows: Float
) -> int:
    """Run a compensator along a recording; return the number of samples, fewer than n once it has diverged.

    The total torque S = F_m + u that drives the inner side in the recording stays. A compensator that gives u' instead
    leaves F' = S - u' to the person, which is what the compensator then measures.

    Args:
        settings: Record of the compensator.
        memory: Its memory; changed.
        tally: Record of TALLY; changed.
        port: The recording.
        cuts: Per sample FIND, or 1 where a cycle ends and 0 elsewhere, shape (n,); one entry stands for all.
        course: Receives what comes out.
        rows: Receives a row per cycle, shape (most, COLUMNS).
    """
    t, dq, torque, logged = port
    before = needed_before = 0.0
    for i in range(len(t)):
        dt = t[i] - t[i - 1] if i > 0 else 0.0
        total = torque[i] + logged[i] if len(logged) > 0 else torque[i]
        u, needed = memory.u_nm, total - memory.u_nm
        course.interaction[i] = needed
        course.compensation[i], course.passivity[i] = memory.compensation_nm, memory.passivity_nm
        if i > 0:
            moved = 0.5 * (dq[i - 1] + dq[i]) * dt
            friction = 0.5 * (before + total) * moved
            exchange = 0.5 * (needed_before + needed) * moved
            count_energy(tally, settings, friction, exchange, moved, dt)
        coulomb, viscous, cycle = memory.coulomb_nm, memory.viscous_nms_per_rad, memory.cycle
        acted = memory.acted
        step(settings, memory, dq[i], needed, dt, cuts[i] if len(cuts) > 1 else cuts[0])
        if memory.unstable == 1:
            return i
        count_tick(tally, settings, memory, u, dt, i)
        if memory.cycle > cycle:
            close_row(tally, memory, coulomb, viscous, acted, i, rows)
        before, needed_before = total, needed
    return len(t)
