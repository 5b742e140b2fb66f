"""Replay: what a compensator would have done on a recorded log, and what that would have saved."""

import math
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from friction_audit.compensation.competitors import Compensator
from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.compensation.records import ESTIMATED, NOT_MOVED, STATUSES
from friction_audit.compensation.replay_loops import GENERATED, STATISTICS, RecordedJoint
from friction_audit.compensation.settings import Limits
from friction_audit.compiled import Record
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import Coefficient, JointFriction, TorqueRegression
from friction_audit.joint_log import Float, Int
from friction_audit.preprocessing.interaction import Caution, Reason

CONVERGED_SHARE = 0.1  # net energy of a converged cycle over its dissipation, at most
CONVERGED_CYCLES = 3  # consecutive cycles of convergence: a single one may be below by chance
UPDATES = 2  # updates of the coefficients after which the compensator is past its initial phase

# A step of friction: least relative change, F ratio of two friction laws over one (logs without a step reach 10 at the
# best split), and share of the change between two cycles (warming up changes friction gradually).
LEAST_CHANGE, LEAST_F_RATIO, SUDDEN_SHARE = 0.25, 50.0, 0.7
ONE_SPEED = 1e-9  # ratio of the eigenvalues of the moments below which all cycles have one speed


@dataclass(frozen=True, eq=False, slots=True)
class Signals:
    """One joint over time, n samples; a torque at sample i is the one in force at t[i]."""

    t: Float  # time [s]
    dq: Float  # velocity [rad/s]
    interaction_nm: Float  # interaction torque, that of the operator [N m]
    compensation_nm: Float  # torque of the compensation law [N m]
    passivity_nm: Float  # torque of the passivity controller [N m]
    limited_nm: Float  # change of their sum by the limits of torque and rate [N m]

    @property
    def net_energy_j(self) -> Float:
        """Net energy input of the operator (2) by trapezoids over the stamps, shape (n,). [J]"""
        power = 0.25 * (self.interaction_nm[1:] + self.interaction_nm[:-1]) * (self.dq[1:] + self.dq[:-1])
        return np.concatenate([[0.0], np.cumsum(power * np.diff(self.t))])


ReplayHistory: TypeAlias = np.recarray[Any, Any]  # a record of CYCLE for each cycle of the compensator


@dataclass(frozen=True, kw_only=True, slots=True)
class Passivity:
    """Passivity of the compensated joint; a violation exceeds the energy exchanged in two samples and the payback."""

    violations: int  # samples at which the observed energy was below zero
    violations_since_activation: int  # the same of the energy observed since the compensator first acted
    active_cycles: int  # cycles in which the joint generated more than 5 % of the energy that friction dissipated
    lowest_j: float  # lowest observed energy [J]
    lowest_since_activation_j: float  # lowest energy observed since the compensator first acted [J]
    reserve_j: float  # observed energy when the compensator first acted [J]
    activation_s: float  # time at which it first acted, NaN if never [s]
    injected_j: float  # energy that the passivity controller dissipated [J]
    active_fraction: float  # share of the time in which the passivity controller acted
    hidden: bool  # True where the reserve of the first cycles hides over-compensation from the observer


@dataclass(frozen=True, kw_only=True, slots=True)
class Recovery:
    """A step of friction, and how the compensator adapted to it."""

    step_s: float  # start of the first cycle after the step [s]
    change: float  # friction after it over friction before it
    cycles: int | None  # cycles until the compensation converged again, None if never
    seconds: float  # time until then, NaN if never [s]


@dataclass(frozen=True, kw_only=True, slots=True)
class Numbers:
    """Figures of merit of a replay."""

    energy_recorded_j: float  # net energy input of the operator in the recording [J]
    energy_without_j: float  # net energy input without a compensator [J]
    energy_with_j: float  # net energy input with it [J]
    # 1 - |energy_with_j| / energy_without_j: over-compensation reduces it like under-compensation
    dissipation_removed: float
    # the same of the cycles from the second update of the coefficients on, with the absolute value of each cycle
    dissipation_removed_updated: float
    peak_torque_without_nm: float  # largest interaction torque without a compensator [N m]
    peak_torque_with_nm: float  # with it [N m]
    rms_torque_without_nm: float  # root mean square over the time [N m]
    rms_torque_with_nm: float  # with it [N m]
    peak_compensation_nm: float  # largest torque of compensator and passivity controller [N m]
    peak_rate_nm_s: float  # fastest change of it [N m/s]
    limited_fraction: float  # share of the samples at a limit of torque or rate
    cycles_to_converge: int | None  # cycles before the compensation converged, None if never
    diverged_s: float  # time at which the loop diverged, NaN if it did not [s]


class FittedOperator(NamedTuple):
    """Impedance of the operator with 95 % intervals, NaN if it was given."""

    inertia: Coefficient
    damping: Coefficient
    stiffness: Coefficient
    reversals: int = 0  # reversals that it was fitted to; 0 if it was given


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointReplay:
    """Replay of one joint."""

    joint: int  # number, from 1
    name: str  # name in the log
    compensator: Compensator  # the compensator with thresholds and limits in force
    limits: Limits  # limits in force
    # the joint without a compensator; without samples, as ``replayed``, for a log that is read in blocks
    without: Signals
    # the joint with it, up to a divergence; None, as the results below, where there is a reason
    replayed: Signals | None = None
    history: ReplayHistory | None = None  # per cycle of the compensator
    last: Coefficients | None = None  # coefficients applied after the last cycle that ended, or None
    numbers: Numbers | None = None
    passivity: Passivity | None = None
    recovery: Recovery | None = None  # a step of friction in the log, or None
    model: JointModel | None = None  # the joint's model of a file, or None
    fitted: TorqueRegression | None = None  # the joint fitted to the log, if it was simulated, or None
    operator: FittedOperator | None = None  # impedance of the simulated operator, or None
    simulated: bool = False  # True if a joint, fitted or of a file, was simulated
    # relative rms velocity error of the simulated joint without a compensator, or NaN
    model_error: float = float("nan")
    reason: Reason = ()  # why there is no result for this joint; empty if there is one

    def __repr__(self) -> str:
        if self.numbers is None or self.reason:
            return f"joint {self.joint} {self.name}: not replayed: {'; '.join(map(str, self.reason))}"
        removed, numbers = 100.0 * self.numbers.dissipation_removed, self.numbers
        energy = f"{numbers.energy_without_j:.4g} J without, {numbers.energy_with_j:.4g} J with"
        return f"joint {self.joint} {self.name}: dissipation removed {removed:.3g} %, net energy {energy}"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Replay:
    """Replay of the joints of a log under one assumption."""

    counterfactual: Caution  # assumption about the operator, or the arm's drive
    joints: tuple[JointReplay, ...]
    warnings: tuple[Caution, ...] = ()


def dissipation_removed(friction_j: Float | float, left_j: Float | float) -> float:
    """Return 1 - sum |left| / sum of friction, over cycles or of the whole; NaN without dissipation."""
    dissipated = float(np.sum(friction_j))
    return 1.0 - float(np.sum(np.abs(left_j))) / dissipated if dissipated > 0.0 else math.nan


def first_converged(history: ReplayHistory, first: int = 0) -> int | None:
    """Return the first of CONVERGED_CYCLES cycles (0-based, from ``first`` on) that converged; None without any."""
    usable = history.friction_j > 0.0
    share_left = np.where(usable, np.abs(history.net_energy_j) / np.where(usable, history.friction_j, 1.0), np.inf)
    converged = share_left[first:] <= CONVERGED_SHARE
    if len(converged) < CONVERGED_CYCLES:
        return None
    runs = np.convolve(converged, np.ones(CONVERGED_CYCLES), "valid") == CONVERGED_CYCLES
    return first + int(np.argmax(runs)) if runs.any() else None


def summarise(
    recorded: Record, without: Record, with_it: Record, statistics: Record, history: ReplayHistory
) -> tuple[Numbers, Passivity]:
    """Summarise a run, from records of TORQUE_SUMS as recorded, without a compensator and with it."""
    in_numbers, in_passivity = (
        {one.name: statistics[one.name].item() for one in fields(kind) if one.name in (STATISTICS.names or ())}
        for kind in (Numbers, Passivity)
    )
    updates = np.flatnonzero(history.status == ESTIMATED)[UPDATES - 1 :]
    updated = int(updates[0]) + 1 if len(updates) else len(history)
    without_j, with_j = float(without["work_j"]), float(with_it["work_j"])
    numbers = Numbers(
        **in_numbers,
        energy_recorded_j=float(recorded["work_j"]),
        energy_without_j=without_j,
        energy_with_j=with_j,
        dissipation_removed=dissipation_removed(without_j, with_j),
        dissipation_removed_updated=dissipation_removed(history.friction_j[updated:], history.net_energy_j[updated:]),
        peak_torque_without_nm=float(without["peak_nm"]),
        peak_torque_with_nm=float(with_it["peak_nm"]),
        rms_torque_without_nm=math.sqrt(without["square_nm2s"] / without["t_s"]),
        rms_torque_with_nm=math.sqrt(with_it["square_nm2s"] / with_it["t_s"]),
        limited_fraction=float(statistics["limited"]) / float(with_it["samples"]),
        cycles_to_converge=first_converged(history),
    )
    active = history.net_energy_j < -GENERATED * np.abs(history.friction_j)
    share = float(statistics["acting_s"]) / float(statistics["t_s"])
    return numbers, Passivity(**in_passivity, active_cycles=int(active.sum()), active_fraction=share)


def model_error(recorded: RecordedJoint, without: Signals) -> float:
    """Return the relative rms error of the velocity without a compensator; NaN if one was active in the recording."""
    if recorded.total is not recorded.torque or len(without.t) < len(recorded.t):
        return float("nan")
    square = max(np.sum(recorded.dq**2), np.finfo(float).tiny)
    return float(np.sqrt(np.sum((without.dq - recorded.dq) ** 2) / square))


def find_recovery(history: ReplayHistory) -> Recovery | None:
    """Find the largest step of friction in a log and how the compensator adapted to it; None without one."""
    found = find_step(history.path_rad, history.square_speed_rad2_s, history.friction_j)
    if found is None:
        return None
    row, change = found
    converged, start_s = first_converged(history, row), history.start_s.tolist()
    cycles, seconds = (None, math.nan) if converged is None else (converged - row, start_s[converged] - start_s[row])
    return Recovery(step_s=start_s[row], change=change, cycles=cycles, seconds=seconds)


def find_step(path: Float, square: Float, friction: Float) -> tuple[int, float] | None:
    """Return the first cycle after a step of friction, and friction after over before; None without a step.

    Coulomb and viscous friction are fitted before and after every split; the best split is tested. Of each cycle, shape
    (m,): path [rad], integral of its squared velocity [rad^2/s], energy that friction dissipated [J].
    """
    cycles = len(path)
    if cycles < 2 * CONVERGED_CYCLES or not path.min() > 0.0 or not friction.any():
        return None
    rows = np.stack([np.ones(cycles), square / path, friction / path], axis=1)
    whole = np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)
    splits: Int = np.arange(CONVERGED_CYCLES, cycles - CONVERGED_CYCLES + 1)
    (before, left_before), (after, left_after) = (
        _fit_friction(whole[splits - 1]),
        _fit_friction(whole[-1] - whole[splits - 1]),
    )
    left = left_before + left_after
    best = int(np.argmin(left))
    row, one = int(splits[best]), float(_fit_friction(whole[-1:])[1][0])
    least = np.finfo(float).eps * one + np.finfo(float).tiny  # friction may be one number to the last digit
    ratio = (one - left[best]) / 2.0 / max(left[best] / max(cycles - 4, 1), least)
    law, later = rows[:, :2] @ before[best], rows[:, :2] @ after[best]
    change = float(later.sum() / law.sum())
    level = np.divide(rows[:, 2], law, out=np.ones(cycles), where=law != 0.0)
    near = float(np.median(level[row : row + CONVERGED_CYCLES]) - np.median(level[row - CONVERGED_CYCLES : row]))
    step = change - 1.0
    sudden = near * step > 0.0 and abs(near) > SUDDEN_SHARE * abs(step)
    return (row, change) if ratio > LEAST_F_RATIO and change > 0.0 and abs(step) > LEAST_CHANGE and sudden else None


def _fit_friction(moments: Float) -> tuple[Float, Float]:
    """Fit Coulomb and viscous friction to the mean friction torque of cycles over their mean speed.

    From sums of the products of one, speed and torque, shape (s, 3, 3): coefficients (s, 2), squared residuals (s,).
    """
    inverse, torque = np.linalg.pinv(moments[:, :2, :2], rcond=ONE_SPEED, hermitian=True), moments[:, :2, 2]
    found = np.einsum("sij,sj->si", inverse, torque)
    return found, np.maximum(moments[:, 2, 2] - np.einsum("si,si->s", found, torque), 0.0)


def missing_estimate(history: ReplayHistory, friction: JointFriction, compensator: Compensator) -> Reason:
    """Return why there was no cycle with an estimate to apply; empty if there was one."""
    cycles = len(history)
    if not cycles:
        return friction.reason or (Caution("no_cycle_ended"),)
    if not isinstance(compensator, EnergyCompensator) or compensator.forced or (history.status[:-1] == ESTIMATED).any():
        return ()
    refused = history.status[history.status >= NOT_MOVED]
    if len(refused):
        case = STATUSES[int(np.bincount(refused).argmax())]
        return (Caution("no_cycle_estimates", numbers={"cycles": cycles, "case": case}),)
    return (Caution("fewer_than_window", numbers={"cycles": cycles, "needed": compensator.cycles_per_estimate}),)
