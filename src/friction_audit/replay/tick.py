"""A tick of the controller within a replay, whatever moves the joint; compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.compensators.kind import JOINT_MODEL
from friction_audit.replay.feed_forward import Feed, tell_friction
from friction_audit.replay.kernels import step
from friction_audit.replay.port import Course
from friction_audit.replay.records import Record
from friction_audit.replay.tally import close_row, count_tick


class Control(NamedTuple):
    """What runs beside a joint, and where it is written down.

    Attributes:
        settings: Record of the compensator.
        memory: Its memory; changed.
        tally: Record of TALLY; changed.
        feed: What a compensator with a joint's model is told.
        cuts: Per sample FIND, or 1 where a cycle ends and 0 elsewhere, shape (n,); one entry stands for all.
        course: Receives the torques.
        rows: Receives a row per cycle, shape (most, COLUMNS).
    """

    settings: Record
    memory: Record
    tally: Record
    feed: Feed
    cuts: NDArray[np.int64]
    course: Course
    rows: Float


@compiled()
def tick(control: Control, i: int, dt: float, q: float, v: float, interaction: float) -> bool:
    """Write sample i down and run the compensator on it; return False once the loop has diverged.

    Args:
        control: What runs.
        i: Sample.
        dt: Time since the sample before. [s]
        q: Position; only a compensator with a joint's model reads it. [rad]
        v: Velocity. [rad/s]
        interaction: Torque at the sensor. [N m]
    """
    memory, course = control.memory, control.course
    course.interaction[i] = interaction
    course.compensation[i], course.passivity[i] = memory.compensation_nm, memory.passivity_nm
    u, cycle, acted = memory.u_nm, memory.cycle, memory.acted
    coulomb, viscous = memory.coulomb_nm, memory.viscous_nms_per_rad
    if control.settings.kind == JOINT_MODEL:
        tell_friction(memory, control.feed, q, v, i)
    cut = control.cuts[i] if len(control.cuts) > 1 else control.cuts[0]
    step(control.settings, memory, v, interaction, dt, cut)
    if memory.unstable == 1:
        return False
    count_tick(control.tally, control.settings, memory, u, dt, i)
    if memory.cycle > cycle:
        close_row(control.tally, memory, coulomb, viscous, acted, i, control.rows)
    return True


@compiled()
def interval(t: Float, i: int) -> float:
    """Return the time since the sample before, 0 at the first one. [s]"""
    return t[i] - t[i - 1] if i > 0 else 0.0
