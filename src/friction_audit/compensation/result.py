"""Replay: what a compensator would have done on a recorded log, and what that would have saved."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.compensators import Coefficients, Compensator
from friction_audit.compensation.operator_fit import FittedOperator
from friction_audit.compensation.settings import Counterfactual, Limits
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import TorqueRegression
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution

# Names of the values of ``status`` in ``records``: what came of a cycle.
STATUSES = ("no_cycle", "estimated", "too_few", "not_moved", "gap")


@dataclass(frozen=True, eq=False, slots=True)
class Signals:
    """One joint over time, n samples; a torque at sample i is the one in force at t[i]."""

    t: Float  # time [s]
    dq: Float  # velocity [rad/s]
    interaction_nm: Float  # torque of the person, the interaction torque [N m]
    compensation_nm: Float  # torque that the compensator's law asks for [N m]
    passivity_nm: Float  # torque that its passivity controller adds [N m]
    limited_nm: Float  # what the limits of torque and rate change of their sum [N m]

    @property
    def net_energy_j(self) -> Float:
        """Net energy that the person has put in so far (2), trapezoids on the real stamps, shape (n,). [J]"""
        power = 0.25 * (self.interaction_nm[1:] + self.interaction_nm[:-1]) * (self.dq[1:] + self.dq[:-1])
        return np.concatenate([[0.0], np.cumsum(power * np.diff(self.t))])


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class ReplayHistory:
    """What happened in each cycle of the compensator, m rows."""

    stop: NDArray[np.int64]  # sample at which the cycle ended, shape (m,)
    start_s: Float
    stop_s: Float
    friction_j: Float  # what friction took, which the person would have had to give without compensation [J]
    net_energy_j: Float  # that less what compensator and passivity controller gave: what was left to the person [J]
    path_rad: Float  # path [rad]
    square_speed_rad2_s: Float  # integral of dq^2 dt [rad^2/s]
    coulomb_applied_nm: Float  # Coulomb friction compensated during the cycle [N m]
    viscous_applied_nms_per_rad: Float  # viscous friction compensated during it [N m s/rad]
    coulomb_estimated_nm: Float  # estimate in force after its end, NaN before there is one [N m]
    viscous_estimated_nms_per_rad: Float  # likewise [N m s/rad]
    acted: NDArray[np.bool_]  # True if the passivity controller acted in it
    status: NDArray[np.int64]  # what came of it, as in ``records``


@dataclass(frozen=True, kw_only=True, slots=True)
class Passivity:
    """How passive the compensated joint stayed; a violation is beyond what two samples and the payback exchange."""

    violations: int  # samples at which the ledger from the start was below zero
    violations_since_activation: int  # likewise of the ledger that begins when the compensator first acts
    active_cycles: int  # cycles in which the joint gave out more than 5 % of what friction took
    lowest_j: float  # lowest value of the ledger from the start [J]
    lowest_since_activation_j: float  # lowest value of the other one [J]
    reserve_j: float  # what the ledger held when the compensator first acted [J]
    activation_s: float  # when that was, NaN if never [s]
    injected_j: float  # what the passivity controller dissipated [J]
    active_fraction: float  # share of the time for which the passivity controller acted
    hidden: bool  # True where the reserve of the first cycles hides over-compensation from the ledger


@dataclass(frozen=True, kw_only=True, slots=True)
class Recovery:
    """A step of friction, and how the compensator got over it."""

    step_s: float  # when friction changed, the start of the first cycle after it [s]
    change: float  # friction after it over friction before it
    cycles: int | None  # cycles until the compensation was right again, None if it never was
    seconds: float  # time until then, NaN if it never was [s]


@dataclass(frozen=True, kw_only=True, slots=True)
class Numbers:
    """What a replay comes to."""

    energy_recorded_j: float  # net energy of the person in the recording [J]
    energy_without_j: float  # net energy without a compensator [J]
    energy_with_j: float  # net energy with it [J]
    # one less the size of ``energy_with_j`` over ``energy_without_j``: energy that is given out counts as left over, so
    # that over-compensation is no merit
    dissipation_removed: float
    # likewise of the cycles from the second update of the coefficients on, where what a single cycle gives out counts
    # as left over
    dissipation_removed_updated: float
    peak_torque_without_nm: float  # largest interaction torque without a compensator [N m]
    peak_torque_with_nm: float  # with it [N m]
    rms_torque_without_nm: float  # root mean square over the time [N m]
    rms_torque_with_nm: float  # with it [N m]
    peak_compensation_nm: float  # largest torque of compensator and passivity controller [N m]
    peak_rate_nm_s: float  # fastest change of it [N m/s]
    limited_fraction: float  # share of the samples at a limit of torque or rate
    cycles_to_converge: int | None  # cycles before the compensation stayed right, None if it never did
    diverged_s: float  # when the loop ran away, NaN if it did not [s]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointReplay:
    """One joint."""

    joint: int  # number for people
    name: str  # name in the log
    compensator: Compensator  # what ran, thresholds and limits as in force
    limits: Limits  # limits in force
    # the joint without a compensator; of a log that is read in blocks without samples, as ``replayed``
    without: Signals
    # the joint with it, up to where it diverged, if it did; None where there is a reason, as below
    replayed: Signals | None = None
    history: ReplayHistory | None = None  # per cycle of the compensator
    last: Coefficients | None = None  # coefficients applied after the last cycle that ended, or None
    numbers: Numbers | None = None  # what it comes to
    passivity: Passivity | None = None  # how passive it stayed
    recovery: Recovery | None = None  # a step of friction in the log, or None
    model: JointModel | None = None  # the joint's model of a file, or None
    fitted: TorqueRegression | None = None  # the joint fitted to the log that moved otherwise than recorded, or None
    operator: FittedOperator | None = None  # the person who moved it, or None
    simulated: bool = False  # True if a joint, fitted or of a file, moved otherwise than recorded
    # how far the simulated joint without a compensator is from the recorded motion, over this; or NaN
    model_error: float = float("nan")
    reason: str = ""  # why the replay means nothing for this joint; empty if it does

    def __repr__(self) -> str:
        if self.numbers is None or self.reason:
            return f"joint {self.joint} {self.name}: not replayed: {self.reason.partition(';')[0]}"
        removed, numbers = 100.0 * self.numbers.dissipation_removed, self.numbers
        energy = f"{numbers.energy_without_j:.4g} J without, {numbers.energy_with_j:.4g} J with"
        return f"joint {self.joint} {self.name}: dissipation removed {removed:.3g} %, net energy {energy}"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Replay:
    """All joints of a log under one assumption."""

    counterfactual: Counterfactual
    joints: tuple[JointReplay, ...]
    warnings: tuple[Caution, ...] = field(default=())
