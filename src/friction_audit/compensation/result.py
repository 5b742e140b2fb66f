"""Replay: what a compensator would have done on a recorded log, and what that would have saved."""

import math
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.closed_loop import GIVEN_OUT, TALLY, Recorded
from friction_audit.compensation.competitors import Compensator
from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.compensation.records import ESTIMATED, NOT_MOVED, STATUSES
from friction_audit.compensation.settings import Limits
from friction_audit.compiled import Record
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import Coefficient, JointFriction, TorqueRegression
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution, Reason

RIGHT = 0.1  # share of the dissipation up to which what is left to the person, or given out, counts as right
IN_A_ROW = 3  # so many cycles must be right, one after the other: a single one may be so by chance
UPDATES = 2  # from this update of the coefficients on, the compensator is past its beginning

LEAST_CHANGE = 0.25  # a step of friction changes it by so much of what it was
SURE = 50.0  # F ratio of two laws over one: logs without a step reach 10 at most, although the split is the best one
AT_ONCE = 0.7  # so much of it happens from one cycle to the next: warming up is no step
TOO_ALIKE = 1e-9  # ratio of the eigenvalues of the moments below which cycles are of one speed


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


ReplayHistory: TypeAlias = np.recarray[Any, Any]  # a record of CYCLE for each cycle of the compensator


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


class FittedOperator(NamedTuple):
    """Impedance of the person with its 95 % intervals; given ones have none."""

    inertia: Coefficient
    damping: Coefficient
    stiffness: Coefficient
    reversals: int = 0  # reversals it rests on; 0 if it was given


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
    reason: Reason = ()  # why the replay means nothing for this joint; empty if it does

    def __repr__(self) -> str:
        if self.numbers is None or self.reason:
            return f"joint {self.joint} {self.name}: not replayed: {'; '.join(map(str, self.reason))}"
        removed, numbers = 100.0 * self.numbers.dissipation_removed, self.numbers
        energy = f"{numbers.energy_without_j:.4g} J without, {numbers.energy_with_j:.4g} J with"
        return f"joint {self.joint} {self.name}: dissipation removed {removed:.3g} %, net energy {energy}"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Replay:
    """All joints of a log under one assumption."""

    counterfactual: Caution  # what is assumed of the person, or of the arm's drive
    joints: tuple[JointReplay, ...]
    warnings: tuple[Caution, ...] = ()


def dissipation_removed(friction_j: Float | float, left_j: Float | float) -> float:
    """Return the share of the dissipation, of cycles or of all, that is gone; what is given out counts as left over."""
    dissipated = float(np.sum(friction_j))
    return 1.0 - float(np.sum(np.abs(left_j))) / dissipated if dissipated > 0.0 else math.nan


def first_right(history: ReplayHistory, first: int = 0) -> int | None:
    """Return the first cycle (0-based), not before ``first``, from which on IN_A_ROW are right; None if never."""
    usable = history.friction_j > 0.0
    share_left = np.where(usable, np.abs(history.net_energy_j) / np.where(usable, history.friction_j, 1.0), np.inf)
    right = share_left[first:] <= RIGHT
    if len(right) < IN_A_ROW:
        return None
    runs = np.convolve(right, np.ones(IN_A_ROW), "valid") == IN_A_ROW
    return first + int(np.argmax(runs)) if runs.any() else None


def measure(
    recorded: Record, without: Record, felt: Record, tally: Record, history: ReplayHistory
) -> tuple[Numbers, Passivity]:
    """Return what a run comes to, from sums of the torque as recorded, without a compensator and with it."""
    in_numbers, in_passivity = (
        {one.name: tally[one.name].item() for one in fields(kind) if one.name in (TALLY.names or ())}
        for kind in (Numbers, Passivity)
    )
    updates = np.flatnonzero(history.status == ESTIMATED)[UPDATES - 1 :]
    updated = int(updates[0]) + 1 if len(updates) else len(history)
    without_j, with_j = float(without["work_j"]), float(felt["work_j"])
    numbers = Numbers(
        **in_numbers,
        energy_recorded_j=float(recorded["work_j"]),
        energy_without_j=without_j,
        energy_with_j=with_j,
        dissipation_removed=dissipation_removed(without_j, with_j),
        dissipation_removed_updated=dissipation_removed(history.friction_j[updated:], history.net_energy_j[updated:]),
        peak_torque_without_nm=float(without["largest_nm"]),
        peak_torque_with_nm=float(felt["largest_nm"]),
        rms_torque_without_nm=math.sqrt(without["square_nm2s"] / without["t_s"]),
        rms_torque_with_nm=math.sqrt(felt["square_nm2s"] / felt["t_s"]),
        limited_fraction=float(tally["limited"]) / float(felt["samples"]),
        cycles_to_converge=first_right(history),
    )
    given_out = history.net_energy_j < -GIVEN_OUT * np.abs(history.friction_j)
    share = float(tally["acting_s"]) / float(tally["t_s"])
    return numbers, Passivity(**in_passivity, active_cycles=int(given_out.sum()), active_fraction=share)


def model_error(recorded: Recorded, without: Signals) -> float:
    """Return how far the velocity without a compensator is from the recorded one, over this; NaN if one acted in it."""
    if len(recorded.logged) or len(without.t) < len(recorded.t):
        return float("nan")
    square = max(np.sum(recorded.dq**2), np.finfo(float).tiny)
    return float(np.sqrt(np.sum((without.dq - recorded.dq) ** 2) / square))


def find_recovery(history: ReplayHistory) -> Recovery | None:
    """Find the largest step of friction in a log and how the compensator got over it; None without one."""
    found = find_step(history.path_rad, history.square_speed_rad2_s, history.friction_j)
    if found is None:
        return None
    row, change = found
    right, start_s = first_right(history, row), history.start_s.tolist()
    cycles, seconds = (None, math.nan) if right is None else (right - row, start_s[right] - start_s[row])
    return Recovery(step_s=start_s[row], change=change, cycles=cycles, seconds=seconds)


def find_step(path: Float, square: Float, friction: Float) -> tuple[int, float] | None:
    """Return the first cycle after a step of friction, and friction after over before; None without a step.

    Before and after it, Coulomb and viscous friction of their own describe the cycles: the split where they do so best.
    Of each cycle, shape (m,): path [rad], integral of its squared velocity [rad^2/s], what friction took [J].
    """
    cycles = len(path)
    if cycles < 2 * IN_A_ROW or not path.min() > 0.0 or not friction.any():
        return None
    rows = np.stack([np.ones(cycles), square / path, friction / path], axis=1)
    whole = np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)
    splits: NDArray[np.int64] = np.arange(IN_A_ROW, cycles - IN_A_ROW + 1)
    (before, left_before), (after, left_after) = _fit(whole[splits - 1]), _fit(whole[-1] - whole[splits - 1])
    left = left_before + left_after
    best = int(np.argmin(left))
    row, one = int(splits[best]), float(_fit(whole[-1:])[1][0])
    ratio = (one - left[best]) / 2.0 / max(left[best] / max(cycles - 4, 1), np.finfo(float).eps * one)
    law, later = rows[:, :2] @ before[best], rows[:, :2] @ after[best]
    change = float(later.sum() / law.sum())
    level = np.divide(rows[:, 2], law, out=np.ones(cycles), where=law != 0.0)
    near = float(np.median(level[row : row + IN_A_ROW]) - np.median(level[row - IN_A_ROW : row]))
    step = change - 1.0
    sudden = near * step > 0.0 and abs(near) > AT_ONCE * abs(step)
    return (row, change) if ratio > SURE and change > 0.0 and abs(step) > LEAST_CHANGE and sudden else None


def _fit(moments: Float) -> tuple[Float, Float]:
    """Fit the mean friction torque of cycles by a constant and a multiple of their mean speed.

    From sums of the products of one, speed and torque, shape (s, 3, 3): coefficients (s, 2) and squares left over (s,).
    """
    inverse, torque = np.linalg.pinv(moments[:, :2, :2], rcond=TOO_ALIKE, hermitian=True), moments[:, :2, 2]
    found = np.einsum("sij,sj->si", inverse, torque)
    return found, np.maximum(moments[:, 2, 2] - np.einsum("si,si->s", found, torque), 0.0)


def missing_estimate(history: ReplayHistory, friction: JointFriction, compensator: Compensator) -> Reason:
    """Return why there was nothing to apply; empty if there was."""
    cycles = len(history)
    if not cycles:
        return friction.reason or (Caution("no_cycle_ended"),)
    if not isinstance(compensator, EnergyCompensator) or compensator.forced or (history.status == ESTIMATED).any():
        return ()
    refused = history.status[history.status >= NOT_MOVED]
    if len(refused):
        case = STATUSES[int(np.bincount(refused).argmax())]
        return (Caution("no_cycle_estimates", numbers={"cycles": cycles, "case": case}),)
    return (Caution("fewer_than_window", numbers={"cycles": cycles, "needed": compensator.cycles_per_estimate}),)
