"""Interaction, EnergyCycles -> FrictionHistory."""

from dataclasses import dataclass, fields
from functools import partial

import numpy as np

from friction_audit.cycles.energy_cycles import KEPT, EnergyCycles
from friction_audit.friction.equations import Equations, set_up
from friction_audit.friction.history import (
    UNDETERMINED,
    Coefficient,
    CoefficientHistory,
    FrictionHistory,
    JointFriction,
)
from friction_audit.friction.methods import conclude
from friction_audit.friction.paper import estimate_paper
from friction_audit.friction.reasons import dead_channel, missing_motion, one_speed
from friction_audit.friction.settings import FEWEST_CYCLES, FrictionSettings
from friction_audit.friction.torque_regression import regress_torque
from friction_audit.friction.weighted import conditioning, fit_windows
from friction_audit.interaction.interaction import Caution, Interaction
from friction_audit.joint_log import Float
from friction_audit.per_joint import per_joint

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
