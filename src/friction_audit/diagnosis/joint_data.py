"""What one joint did and what drove it, on an even grid: the ground on which a model is held against a recording."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.mean_sign import mean_sign
from friction_audit.dynamics.rigid_body import RigidBody
from friction_audit.effects.term import Motion, Others
from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True)
class JointData:
    """One joint on an even grid of n samples; j joints in the log.

    Torque and motion went through one and the same zero-phase low-pass, so that what holds between them still holds.

    Attributes:
        joint: Which joint, column of the interaction.
        t: Time, shape (n,), evenly spaced. [s]
        q: Position, shape (n,). [rad]
        dq: Velocity. [rad/s]
        ddq: Acceleration, the derivative of the filtered velocity. [rad/s^2]
        torque: What drives the side on which friction acts: F_m plus a logged compensator. [N m]
        gravity: Gravity torque where it is known, else None. [N m]
        temperature: Temperature where it was logged, else None. [degC]
        load: What the sensor bears besides what the joint's own model takes, counted as the torque counts: gravity, and
            the links' inertia where it was taken away; predicted, None where it is not known, shape (n,). [N m]
        rigid: What the rigid-body model of the arm says about the joint, None where no model is known.
        others_dq: Velocities of all joints, shape (n, j). [rad/s]
        others_ddq: Accelerations of all joints, shape (n, j). [rad/s^2]
        others_torque: What the torque sensors of all joints read, gravity included, counted as the torque counts,
            shape (n, j). [N m]
        others_joint: Column of this joint among them; ``joint`` where None.
        sample_s: Usual step of the log itself, 0 where a torque that is late by part of it is of no interest. [s]
        cycle: Number of the energy cycle of each sample, -1 outside of any, shape (n,).
        moving: Samples in which the direction of motion is certain, shape (n,).
        valid: Samples that are not next to a hole, a stale stretch or an end of the filter, shape (n,).
        dead_speed_rad_s: Below this speed the direction is not certain. [rad/s]
        derived_from: ``"q"`` or ``"dq"``: what velocity and acceleration were taken from.
        crossover_hz: Below it a velocity from ``"dq"`` is rather the position's derivative (``both_velocities``). [Hz]
        logged_dq: Velocity as it was logged, through the same filter; ``dq`` where None, shape (n,). [rad/s]
    """

    joint: int
    t: Float
    q: Float
    dq: Float
    ddq: Float
    torque: Float
    gravity: Float | None
    temperature: Float | None
    others_dq: Float
    others_ddq: Float
    others_torque: Float
    cycle: NDArray[np.int64]
    moving: NDArray[np.bool_]
    valid: NDArray[np.bool_]
    dead_speed_rad_s: float
    derived_from: str = "dq"
    logged_dq: Float | None = None
    load: Float | None = None
    rigid: RigidBody | None = None
    others_joint: int | None = None
    sample_s: float = 0.0
    crossover_hz: float = 0.0

    @property
    def used(self) -> NDArray[np.bool_]:
        """Samples on which a model is fitted: moving, valid and in a cycle."""
        return self.moving & self.valid & (self.cycle >= 0)

    @property
    def own_column(self) -> int:
        """Column of this joint in the arrays of all joints."""
        return self.joint if self.others_joint is None else self.others_joint

    @property
    def step_s(self) -> float:
        """Spacing of the grid. [s]"""
        return float(self.t[1] - self.t[0])

    @cached_property
    def way(self) -> Float:
        """Mean sign of the velocity over the cell of each sample, shape (n,)."""
        return mean_sign(self.t, self.dq, self.ddq)

    @cached_property
    def smooth(self) -> dict[float, Motion]:
        """The motion behind low-passes, by their corners, as far as somebody has asked for it. [Hz]"""
        return {}

    def motion(self, rest: Float | None = None) -> Motion:
        """What a term of a model may know of this joint; ``rest`` is the torque of the declared model, shape (n,)."""
        others = Others(joint=self.own_column, dq=self.others_dq, ddq=self.others_ddq, sensed=self.others_torque)
        return Motion(
            t=self.t,
            q=self.q,
            dq=self.dq,
            ddq=self.ddq,
            load=self.load,
            temperature=self.temperature,
            others=others if self.others_dq.shape[1] > 1 else None,
            rest=rest,
            rigid=self.rigid,
            way=self.way,
        )
