"""What one joint did and what drove it, on an even grid, and what the grids of effects are measured in."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from friction_audit.dynamics.motion import Motion, Others, RigidBody
from friction_audit.joint_log import Float

Index = NDArray[np.int64]

CORNER_HZ = 25.0  # highest corner of the low-pass before a regression
SIGMA_PER_MEDIAN = 1.4826
# Of noise that is white up to the corner, a fifth of the grid's rate, per RMS of its second and fourth difference.
SIGMA_PER_BEND = {2: 1.0 / 0.643, 4: 1.0 / 0.670}


def mean_sign(t: Float, dq: Float, ddq: Float) -> Float:
    """Return the mean sign of a velocity from half a sample before to half a sample after, shape (n,).

    A sharp sign changes at a sample, a reversal anywhere between two: at 400 Hz a millisecond of twice the Coulomb
    friction, more than the noise of a good sensor.

    Args:
        t: Evenly spaced times, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        ddq: Its slope there, shape (n,). [rad/s^2]
    """
    if len(t) < 2:  # noqa: PLR2004 - one sample has no cell
        return np.sign(dq)
    change = np.maximum(0.5 * (t[1] - t[0]) * np.abs(ddq), np.abs(dq))
    return np.asarray(np.divide(dq, change, out=np.zeros(len(dq)), where=change > 0.0))


def grid_noise(signal: Float, differences: int = 2) -> float:
    """Return the standard deviation of a signal's noise, from differences that no motion reaches.

    Args:
        signal: Shape (n,).
        differences: 2 for a velocity or a torque; 4 for a position, whose second ones are a motion's acceleration.
    """
    bend = np.abs(np.diff(signal, n=differences))
    return SIGMA_PER_BEND[differences] * SIGMA_PER_MEDIAN * float(np.median(bend)) if len(bend) else 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class JointData:
    """One joint on an even grid of n samples; j joints in the log.

    Torque and motion went through one and the same zero-phase low-pass, so that relations between them still hold.

    Attributes:
        joint: Which joint, column of the interaction.
        t: Time, shape (n,), evenly spaced. [s]
        q: Position, shape (n,). [rad]
        dq: Velocity. [rad/s]
        ddq: Acceleration, the derivative of the filtered velocity. [rad/s^2]
        torque: What drives the side on which friction acts: F_m plus a logged compensator. [N m]
        temperature: Temperature where it was logged, else None. [degC]
        load: What the sensor bears in addition to the joint's own model, with the sign of the torque: gravity, and
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
        crossover_hz: Below it a velocity from ``"dq"`` is mainly the derivative of the position. [Hz]
        logged_dq: Velocity as it was logged, through the same filter; ``dq`` where None, shape (n,). [rad/s]
    """

    joint: int
    t: Float
    q: Float
    dq: Float
    ddq: Float
    torque: Float
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
        """The low-passed motion by corner, as far as it was asked for. [Hz]"""
        return {}

    def motion(self, rest: Float | None = None) -> Motion:
        """The input of an effect's columns; ``rest`` is the torque of the nominal model, shape (n,)."""
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


def speeds(data: JointData, *percent: float) -> Float:
    """Percentiles of the speed while the joint moves, never 0, shape (k,). [rad/s]"""
    speed = np.abs(data.dq[data.used]) if data.used.any() else np.abs(data.dq)
    return np.asarray(np.maximum(np.percentile(speed, percent), data.dead_speed_rad_s))


def reach(data: JointData) -> tuple[float, float]:
    """Lowest and highest position while the joint moves. [rad]"""
    q = data.q[data.used] if data.used.any() else data.q
    return float(q.min()), float(q.max())


def duration(data: JointData) -> float:
    """Length of the log. [s]"""
    return float(data.t[-1] - data.t[0])


@dataclass(frozen=True, kw_only=True, slots=True)
class Nominal:
    """The nominal model as fitted to a joint: what columns may be built on, never the measured torque itself.

    Attributes:
        inertia_kg_m2: Inertia. [kg m^2]
        coulomb_nm: Coulomb friction. [N m]
        viscous_nms_per_rad: Viscous friction. [N m s/rad]
        torque: Torque that the model predicts, shape (n,). [N m]
        declared: Names of the numbers above that were stated; all others were fitted.
    """

    inertia_kg_m2: float
    coulomb_nm: float
    viscous_nms_per_rad: float
    torque: Float
    declared: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Strokes:
    """Strokes on a grid of n samples.

    Attributes:
        direction: -1, 1, or 0 before the first motion, shape (n,).
        displacement: Position less that at the last reversal, 0 before the first motion, shape (n,). [rad]
        elapsed: Time since the last reversal, or since the first sample, shape (n,). [s]
        reversals: Samples at which the direction turns, the first motion not among them, shape (r,).
    """

    direction: Float
    displacement: Float
    elapsed: Float
    reversals: Index


def strokes(data: JointData) -> Strokes:
    """Cut the motion at its reversals; a direction holds until the opposite one is certain (hysteresis)."""
    direction = _held_direction(data.dq, data.dead_speed_rad_s)
    turns = np.flatnonzero(np.diff(direction) != 0) + 1
    starts = _first_with_new_sign(data.dq, turns, direction[turns])
    for start, turn in zip(starts, turns, strict=True):
        direction[start:turn] = direction[turn]
    since = np.zeros(len(data.t), dtype=np.int64)
    since[starts] = starts
    since = np.maximum.accumulate(since)
    displacement = np.where(direction == 0, 0.0, data.q - data.q[since])
    later = starts[1:] if len(turns) and turns[0] > 0 else starts
    return Strokes(direction=direction, displacement=displacement, elapsed=data.t - data.t[since], reversals=later)


def _held_direction(dq: Float, dead_speed: float) -> Float:
    """Sign of the velocity, held through what is too slow to have one, shape (n,)."""
    sign = np.where(np.abs(dq) > dead_speed, np.sign(dq), 0.0)
    last = np.maximum.accumulate(np.where(sign != 0, np.arange(len(dq)), -1))
    return np.where(last >= 0, sign[np.maximum(last, 0)], 0.0)


def _first_with_new_sign(dq: Float, turns: Index, direction: Float) -> Index:
    """First sample from which the velocity has the new sign up to each turn, 0 if it always had."""
    samples = np.arange(len(dq))
    not_up, not_down = (np.maximum.accumulate(np.where(side * dq <= 0.0, samples, -1)) for side in (1.0, -1.0))
    return np.asarray(np.where(direction > 0.0, not_up[turns - 1], not_down[turns - 1]) + 1, np.int64)
