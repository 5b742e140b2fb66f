"""What a simulation gives: the log as it was recorded, and everything that the log does not say."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float, JointLog

if TYPE_CHECKING:
    from friction_audit.simulation.mechanics.records import Loop


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TrueMotion:
    """What truly happened at every tick of the controller, free of noise; n + 1 ticks, j joints."""

    t: Float  # time, shape (n + 1,) [s]
    q: Float  # position of the link, shape (n + 1, j), as all that follow [rad]
    dq: Float  # its velocity; exactly 0 where friction holds a rigid joint [rad/s]
    inner_q: Float  # position of the side on which friction acts; q itself in a rigid joint [rad]
    inner_dq: Float  # velocity of that side [rad/s]
    inner_ddq: Float  # acceleration of that side [rad/s^2]
    interaction_nm: Float  # interaction torque F_m at the sensor [N m]
    support_nm: Float  # torque that holds the arm against gravity [N m]
    port_nm: Float  # torque that passes through the sensor towards the side on which friction acts [N m]
    friction_nm: Float  # friction torque tau_f; at rest the torque that holds the joint [N m]
    compensation_nm: Float  # torque of the compensator in force at the tick [N m]
    passivity_nm: Float  # torque of its passivity controller [N m]
    unlogged_nm: Float  # torque of a compensator that the log does not name [N m]
    dissipated_j: Float  # energy that friction has taken so far; bristles give a little of it back [J]
    warmth: Float  # 0 cold, 1 warm


class Moved(NamedTuple):
    """What moved, as far as sensors and recorder read it."""

    motion: TrueMotion
    loop: "Loop"  # compensators and the noise that they saw
    compensators: Mapping[str, Float]  # as in ``Truth``
    gravity: Float | None  # what gravity compensation gave, shape (n + 1, j) [N m]; None where F_m itself is logged


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Truth:
    """What the log does not say."""

    settings: Any  # everything that was simulated
    seed: int  # the seed
    motion: TrueMotion  # the motion, free of noise
    # memory of each joint's compensator at every tick, by the names in ``records.TRACE``; empty without one
    compensators: Mapping[str, Float]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Simulation:
    """A synthetic log and its truth."""

    log: JointLog
    truth: Truth


FASTEST_RAD_S, STRONGEST_NM = 1e3, 1e6  # far beyond all joints of arms


def require_sane(motion: TrueMotion, path: str) -> TrueMotion:
    """Return a motion that did not diverge; refuse one with a speed or torque not finite or beyond all joints."""
    speeds = (motion.dq, motion.inner_dq)
    torques = (motion.port_nm, motion.support_nm, motion.friction_nm, motion.compensation_nm, motion.passivity_nm)
    for signals, limit, what, unit in (
        (speeds, FASTEST_RAD_S, "speed", "rad/s"),
        (torques, STRONGEST_NM, "torque", "N m"),
    ):
        # Written so that NaN, which compares as false, is caught.
        if all(-limit <= signal.min() and signal.max() <= limit for signal in signals):
            continue
        _, ticks, joints = np.nonzero(np.array([~(np.abs(signal) <= limit) for signal in signals]))
        first = ticks.argmin()
        raise AnalysisError(
            f"{path}: the simulation diverged: joint {joints[first] + 1} has a {what} above {limit:g} {unit} at "
            f"{motion.t[ticks[first]]:.3f} s, or none that is a number; nothing was written; set masses, stiffnesses "
            "and torques closer to those of a joint, or leave the effect out"
        )
    return motion
