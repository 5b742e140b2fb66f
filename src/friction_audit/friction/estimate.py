"""Energy cycles and torque regression: which of them gives the coefficients of a joint, and how sure the two are."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np

from friction_audit.friction.history import (
    UNDETERMINED,
    Coefficient,
    CoefficientHistory,
    FrictionHistory,
    JointFriction,
    TorqueRegression,
)
from friction_audit.friction.paper import Equations, estimate_paper, set_up
from friction_audit.friction.reasons import cautions_of, dead_channel, missing_motion, one_speed
from friction_audit.friction.settings import FEWEST_CYCLES, FrictionSettings
from friction_audit.friction.torque_regression import HIGHEST_CONDITION, regress_torque
from friction_audit.friction.weighted import conditioning, fit_windows
from friction_audit.joint_log import Float
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.energy_cycles import KEPT, EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction

ENOUGH = 1 << 16
"""Samples from which a root mean square is taken: to a percent, which is plenty for a bound."""
UNITS = {"coulomb": "nm", "viscous": "nms_per_rad"}
MOST_UNCERTAIN = 2.0
"""An interval of more than so many times the torque in motion on either side (for the viscous coefficient: per rms
speed) does not exclude any friction that the joint could have."""


def conclude(
    joint: JointFriction, interaction: Interaction, own: EnergyCycles, column: int
) -> tuple[JointFriction, tuple[Caution, ...]]:
    """Choose the method of a joint, let its intervals hold what both methods say, and drop what is not determined.

    Args:
        joint: What the cycles say; with a reason, the regression is what could stand for them.
        interaction: Motion and torque.
        own: Its cycles.
        column: Joint, 0-based.

    Returns:
        The joint and what the user must know about it.
    """
    found = joint.regression
    if joint.reason and found is not None:
        joint = _without_energy(joint, found)
    if joint.reason:
        return joint, tuple(cautions_of(joint))
    determined = _determined(joint, _largest(interaction, column, float(own.standstill_rad_s[column])))
    if determined.reason:
        return determined, tuple(cautions_of(determined))
    lost = _lost(joint, determined)
    if joint.method == "regression":
        return determined, (_regression_caution(joint), *lost)
    separate = found is not None and joint.model == "combined" and np.isfinite(joint.coulomb.low)
    alike = bool(separate) and not _speed_condition(own.rows(own.reason == KEPT)) < HIGHEST_CONDITION
    one_profile = (_one_profile_caution(joint),) if alike else ()
    return _covering(determined, alike=alike), (*cautions_of(determined), *one_profile, *lost)


def _without_energy(joint: JointFriction, found: TorqueRegression) -> JointFriction:
    """Return the regression as the estimate, or the reason why there is none."""
    if found.doubt:
        return replace(joint, regression=None, reason=f"{joint.reason}. No torque regression either: {found.doubt}")
    return replace(
        joint,
        method="regression",
        coulomb=found.coulomb,
        viscous=found.viscous,
        offset_nm=found.offset_nm,
        condition_number=found.condition_number,
        correlation=found.correlation,
        reason="",
    )


def _largest(interaction: Interaction, column: int, standstill_rad_s: float) -> dict[str, float]:
    """Return the half width beyond which an interval says nothing, by coefficient."""
    thin = slice(None, None, max(len(interaction.t) // ENOUGH, 1))
    speed, torque = interaction.dq[thin, column], interaction.torque[thin, column]
    if interaction.compensation is not None:
        torque = torque + interaction.compensation[thin, column]
    moving = np.abs(speed) > standstill_rad_s
    torque = torque[moving]
    most = MOST_UNCERTAIN * float(np.sqrt(np.mean(torque**2)))
    return {"coulomb": most, "viscous": most / float(np.sqrt(np.mean(speed[moving] ** 2)))}


def _determined(joint: JointFriction, largest: dict[str, float]) -> JointFriction:
    """Drop the coefficients, of the log and of its history, whose intervals are too wide."""
    changed: dict[str, Any] = {}
    history: dict[str, Any] = {}
    for name, unit in UNITS.items():
        one: Coefficient = getattr(joint, name)
        if one.high - one.low > 2.0 * largest[name]:
            changed[name] = UNDETERMINED
        value, low, high = _history_of(joint, name)
        wide = high - low > 2.0 * largest[name]
        for part, column in (("", value), ("_low", low), ("_high", high)):
            history[f"{name}{part}_{unit}"] = np.where(wide, np.nan, column)
    reason = ""
    if changed and all(np.isnan(changed.get(name, getattr(joint, name)).value) for name in UNITS):
        reason = (
            f"the cycles do not determine its friction: intervals reach more than {MOST_UNCERTAIN:g} times the torque "
            "in motion to either side; move at several speeds, back and forth, with more strokes"
        )
    return replace(joint, **changed, history=replace(joint.history, **history), reason=reason)


def _lost(joint: JointFriction, determined: JointFriction) -> Iterator[Caution]:
    for name in UNITS:
        if np.isnan(getattr(determined, name).value) and not np.isnan(getattr(joint, name).value):
            message = (
                f"joint {joint.joint} ({joint.name}): the {name} coefficient is not determined: its interval is more "
                f"than {MOST_UNCERTAIN:g} times the torque in motion; move at several speeds, with more strokes"
            )
            yield Caution(code=f"{name}_not_determined", joint=joint.joint, message=message)


def _speed_condition(kept: EnergyCycles) -> float:
    """Return the condition number of path and squared speed over whole cycles: of one speed profile it is infinite."""
    columns = np.column_stack([kept.sums.path_rad, kept.sums.square_speed_rad2_s])
    columns = columns / np.sqrt(kept.sums.square_speed_rad2_s)[:, None]
    return float(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)))


def _covering(joint: JointFriction, *, alike: bool) -> JointFriction:
    """Widen the intervals of the log and of its history to the union with those of the regression.

    Where two methods disagree beyond their intervals neither interval holds what the method itself gets wrong, and a
    jackknife over cycles of one speed profile cannot see an error that all of them share.
    """
    if joint.regression is None:
        return joint
    changed: dict[str, Any] = {}
    history: dict[str, Any] = {}
    for name, unit in UNITS.items():
        one, other = getattr(joint, name), getattr(joint.regression, name)
        if (alike and np.isfinite(one.low)) or one.low > other.high or other.low > one.high:
            low, high = np.fmin(one.low, other.low), np.fmax(one.high, other.high)
            changed[name] = replace(one, low=float(low), high=float(high))
            _, lows, highs = _history_of(joint, name)
            history[f"{name}_low_{unit}"] = lows - (one.low - low)
            history[f"{name}_high_{unit}"] = highs + (high - one.high)
    return replace(joint, **changed, history=replace(joint.history, **history))


def _history_of(joint: JointFriction, name: str) -> Iterator[Float]:
    return (getattr(joint.history, f"{name}{part}_{UNITS[name]}") for part in ("", "_low", "_high"))


def _one_profile_caution(joint: JointFriction) -> Caution:
    message = (
        "all cycles have one speed profile, so their energies give friction at its mean speed only; the intervals "
        "cover the torque regression too; move at several speeds"
    )
    return Caution(code="one_speed_profile", joint=joint.joint, message=message)


def _regression_caution(joint: JointFriction) -> Caution:
    message = (
        "too few energy cycles count, so the coefficients are from a regression of the torque on direction, velocity, "
        "acceleration and gravity; it assumes a constant inertia and that no other joint acts on this one"
    )
    return Caution(code="from_regression", joint=joint.joint, message=message)


NAN = float("nan")


def estimate_friction(
    interaction: Interaction,
    cycles: EnergyCycles,
    settings: FrictionSettings,
    dead_torque: frozenset[int] = frozenset(),
) -> FrictionHistory:
    """Estimate the friction of every joint.

    Args:
        interaction: Motion and torque at the friction port.
        cycles: Its energy cycles.
        settings: Estimator, model and window.
        dead_torque: Numbers (1..n) of joints whose torque channel records nothing.

    Returns:
        Coefficients with intervals and history; a joint that cannot be estimated carries the reason.
    """
    work = partial(_estimate_joint, interaction, cycles, settings, dead_torque)
    found = per_joint(work, len(interaction.joint_numbers))
    return FrictionHistory(
        estimator=settings.estimator,
        joints=tuple(joint for joint, _ in found),
        warnings=tuple(caution for _, cautions in found for caution in cautions),
    )


def _estimate_joint(
    interaction: Interaction, cycles: EnergyCycles, settings: FrictionSettings, dead_torque: frozenset[int], column: int
) -> tuple[JointFriction, tuple[Caution, ...]]:
    number = interaction.joint_numbers[column]
    own = cycles.of_joint(column)
    kept = own.rows(own.reason == KEPT)
    reason = dead_channel(interaction, column, dead_torque=number in dead_torque)
    dead = bool(reason)
    reason = reason or missing_motion(own, column, settings, float(interaction.t[-1] - interaction.t[0]))
    instead = bool(reason) and not dead and settings.estimator == "weighted" and settings.model == "combined"
    if not reason and settings.model == "combined":
        reason = one_speed(kept)
    compare = settings.compare and (instead or not reason)
    solution = _NOTHING if reason else _SOLVERS[settings.estimator](own, settings)
    standstill = float(cycles.standstill_rad_s[column])
    joint = JointFriction(
        joint=number,
        name=interaction.joint_names[column],
        model=settings.model,
        window=settings.cycles_per_point,
        cycles=len(kept.joint),
        rejected_cycles=len(own.joint) - len(kept.joint),
        moving_s=float(cycles.moving_s[column]),
        coulomb=solution.coulomb,
        viscous=solution.viscous,
        offset_nm=solution.offset_nm,
        gravity_error_nm=solution.gravity_error_nm,
        condition_number=solution.condition_number,
        correlation=solution.correlation,
        regression=regress_torque(interaction, column, standstill, alone=instead) if compare else None,
        history=solution.history,
        reason=reason,
    )
    return conclude(joint, interaction, own, column)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Solution:
    """What an estimator finds; the fields are those of JointFriction."""

    coulomb: Coefficient = UNDETERMINED
    viscous: Coefficient = UNDETERMINED
    offset_nm: float = NAN
    gravity_error_nm: float = NAN
    condition_number: float = NAN
    correlation: float = NAN
    history: CoefficientHistory


def _solve_weighted(own: EnergyCycles, settings: FrictionSettings) -> _Solution:
    kept = own.rows(own.reason == KEPT)
    equations = set_up(kept, settings.model)
    whole = fit_windows(equations, len(kept.joint))
    condition, correlation = conditioning(equations)
    offset, x, y = (whole.coefficient(name).value for name in ("offset", "gravity_x", "gravity_y"))
    return _Solution(
        coulomb=whole.coefficient("coulomb"),
        viscous=whole.coefficient("viscous"),
        offset_nm=offset,
        gravity_error_nm=float(np.hypot(np.nan_to_num(x), np.nan_to_num(y))),
        condition_number=condition,
        correlation=correlation,
        history=_weighted_history(own, equations, settings.cycles_per_point),
    )


def _weighted_history(own: EnergyCycles, equations: Equations, window: int) -> CoefficientHistory:
    """Estimate after every cycle: over the first cycles with all there are, then over the last k."""
    cycles = len(equations.normal)
    window = min(window, cycles)
    growing = [fit_windows(equations.first(n), n) for n in range(FEWEST_CYCLES, window)]
    fits = [*growing, fit_windows(equations, window)]
    columns = {}
    for name in ("coulomb", "viscous"):
        pairs = [fit.column(name) for fit in fits]
        value, half = (np.concatenate([pair[k] for pair in pairs]) for k in range(2))
        columns[name] = (value, value - half, value + half)
    return _history(own, FEWEST_CYCLES, columns)


def _solve_paper(own: EnergyCycles, settings: FrictionSettings) -> _Solution:
    window = settings.cycles_per_point
    found = estimate_paper(own.rows(own.reason == KEPT), settings.model, window)
    nothing = np.full(len(found), NAN)
    columns = {name: (found[:, k], nothing, nothing) for k, name in enumerate(("coulomb", "viscous"))}
    coulomb, viscous = (_median(found[:, k]) for k in range(2))
    return _Solution(coulomb=coulomb, viscous=viscous, history=_history(own, window, columns))


def _median(values: Float) -> Coefficient:
    """The paper has no value for a whole log and no interval: the median of its estimates stands for the log."""
    known = values[np.isfinite(values)]
    return Coefficient(value=float(np.median(known)), low=NAN, high=NAN) if len(known) else UNDETERMINED


def _history(own: EnergyCycles, first: int, columns: dict[str, tuple[Float, Float, Float]]) -> CoefficientHistory:
    """Gather the history: one row per cycle that counts, from the first one with an estimate on."""
    kept = np.flatnonzero(own.reason == KEPT)[first - 1 :]
    (coulomb, coulomb_low, coulomb_high), (viscous, viscous_low, viscous_high) = columns["coulomb"], columns["viscous"]
    return CoefficientHistory(
        cycle=kept + 1,
        start_s=own.start_s[kept],
        stop_s=own.stop_s[kept],
        coulomb_nm=coulomb,
        coulomb_low_nm=coulomb_low,
        coulomb_high_nm=coulomb_high,
        viscous_nms_per_rad=viscous,
        viscous_low_nms_per_rad=viscous_low,
        viscous_high_nms_per_rad=viscous_high,
        net_energy_j=np.cumsum(own.work_j)[kept],
        dissipated_j=own.dissipated_j[kept],
    )


_EMPTY = np.empty(0)
_NOTHING = _Solution(
    history=CoefficientHistory(
        cycle=np.empty(0, np.int64), **{f.name: _EMPTY for f in fields(CoefficientHistory) if f.name != "cycle"}
    )
)
_SOLVERS = {"weighted": _solve_weighted, "paper": _solve_paper}
