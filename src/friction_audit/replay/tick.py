"""A tick of the controller within a replay, whatever moves the joint; compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.feed_forward import Feed
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
def tick(  # noqa: PLR0913
    settings: Record,
    memory: Record,
    tally: Record,
    i: int,
    dt: float,
    v: float,
    interaction: float,
    cut: int,
    rows: Float,
) -> bool:
    """Run the compensator on sample i and count what it does; return False once the loop has diverged.

    Args:
        settings: Record of the compensator.
        memory: Its memory; changed.
        tally: Record of TALLY; changed.
        i: Sample.
        dt: Time since the sample before. [s]
        v: Velocity. [rad/s]
        interaction: Torque at the sensor. [N m]
        cut: FIND, or 1 where a cycle ends and 0 elsewhere.
        rows: Receives a row per cycle, shape (most, COLUMNS).
    """
    u, cycle, acted = memory.u_nm, memory.cycle, memory.acted
    coulomb, viscous = memory.coulomb_nm, memory.viscous_nms_per_rad
    step(settings, memory, v, interaction, dt, cut)
    if memory.unstable == 1:
        return False
    count_tick(tally, settings, memory, u, dt, i)
    if memory.cycle > cycle:
        close_row(tally, memory, coulomb, viscous, acted, i, rows)
    return True


@compiled()
def write_down(course: Course, i: int, interaction: float, memory: Record) -> None:
    """Write down the torques in force at sample i."""
    course.interaction[i] = interaction
    course.compensation[i], course.passivity[i] = memory.compensation_nm, memory.passivity_nm


@compiled()
def interval(t: Float, i: int) -> float:
    """Return the time since the sample before, 0 at the first one. [s]"""
    return t[i] - t[i - 1] if i > 0 else 0.0
