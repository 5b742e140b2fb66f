"""The friction of every joint: from its energy cycles, or from a torque regression where too few of them count."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from friction_audit.friction import history as results, reasons
from friction_audit.friction.settings import PARTS, FrictionSettings
from friction_audit.friction.torque_regression import CUTOFF_HZ, HIGHEST_CONDITION, RegressionRows, regress_torque
from friction_audit.friction.weighted import FRICTION, fit_windows, normal_equations
from friction_audit.joint_log import JointLog
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.energy_cycles import KEPT, EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction
from friction_audit.preprocessing.segmentation import CycleSearch, Hand, Thresholds
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.preprocessing.velocity import filter_velocity, settling_samples

# A half interval of so many times the torque in motion (the viscous one: per rms speed) excludes no friction at all.
MOST_UNCERTAIN = 2.0
RANK_CUTOFF = 1e-6  # share of the largest singular value below which others are zero: cycles that are copies


class JointPass:
    """Accumulates cycles, signal ranges and regression rows of one joint over consecutive parts of a log."""

    def __init__(
        self, log: JointLog, column: int, settings: CycleSettings, own: Thresholds, hand: Hand | None = None
    ) -> None:
        """Set up for a joint (0-based) of a log and the thresholds of its cycles."""
        self._column, self._rate_hz = column, log.rate_hz
        self.search = CycleSearch(settings, column, self._rate_hz, own, hand)
        self.seen = reasons.SignalRange(column, log.samples)
        self.rows = RegressionRows(column, log.samples, self._rate_hz)
        self._cutoffs_hz = settings.cutoff_hz, CUTOFF_HZ  # of the cycles, and of the regression
        # Samples around new ones, beyond what a filter remembers.
        self.margin = max(self.rows.around, *(settling_samples(self._rate_hz, hz) for hz in self._cutoffs_hz))

    def take(self, part: Interaction, own: Interaction, around: Interaction, *, more: bool) -> None:
        """Add the new samples ``own`` of a part, given with the samples around them; ``more`` if other parts follow."""
        dq, first = around.dq[:, self._column], own.first - around.first
        filtered = {hz: filter_velocity(dq, rate_hz=self._rate_hz, cutoff_hz=hz) for hz in {*self._cutoffs_hz}}
        of_cycles, of_rows = (filtered[hz] for hz in self._cutoffs_hz)
        self.search.take(part, of_cycles[first : first + len(own.t)], more=more)
        self.seen.take(own)
        self.rows.take(around, of_rows, own.first, own.first + len(own.t))


def friction_of(
    port: Interaction,
    every: Sequence[JointPass],
    cycles_of: Callable[[int], EnergyCycles],
    settings: FrictionSettings,
    dead_torque: frozenset[int],
) -> results.FrictionHistory:
    """Estimate the friction of every joint (0-based) after its pass, from its cycles and the rows of all joints."""
    rows = {number: one.rows for number, one in zip(port.joint_numbers, every, strict=True)}

    def estimated(column: int) -> tuple[results.JointFriction, tuple[Caution, ...]]:
        number, seen, own = port.joint_numbers[column], every[column].seen, cycles_of(column)
        kept = own if (own.reason == KEPT).all() else own.rows(own.reason == KEPT)
        dead = reasons.dead_channel(seen, dead_torque=number in dead_torque)
        reason = dead or reasons.missing_motion(own, settings, seen)
        alone = bool(reason) and not dead and settings.estimator == "weighted" and settings.model == "combined"
        if not reason and settings.model == "combined":
            reason = reasons.one_speed(kept)
        standstill, regression = own.standstill_rad_s, None
        if settings.compare and (alone or not reason):
            others = {other: one for other, one in rows.items() if other != number}
            regression = regress_torque(rows[number], standstill, others if alone else None)
        many = len(kept.start)
        window = settings.window or max(min(many // PARTS, settings.cycles_per_point), settings.fewest_cycles)
        joint = results.JointFriction(
            joint=number,
            name=port.joint_names[column],
            model=settings.model,
            window=window,
            cycles=many,
            rejected_cycles=len(own.start) - many,
            moving_s=own.moving_s,
            regression=regression,
            reason=reason,
        )
        if not reason:
            solve = _solve_weighted if settings.estimator == "weighted" else _solve_paper
            joint = replace(joint, **solve(own, kept, settings.model, window))
        return _conclude(joint, seen, kept, standstill)

    found = per_joint(estimated, len(every))
    return results.FrictionHistory(
        estimator=settings.estimator,
        joints=tuple(joint for joint, _ in found),
        warnings=tuple(caution for _, cautions in found for caution in cautions),
    )


def _solve_weighted(own: EnergyCycles, kept: EnergyCycles, model: str, window: int) -> dict[str, Any]:
    equations = normal_equations(kept, model)
    whole = fit_windows(equations, len(kept.start))
    condition, correlation = equations.conditioning()
    window = min(window, len(kept.start))
    offset, x, y = (whole.coefficient(name).value for name in ("offset", "gravity_x", "gravity_y"))
    moved = fit_windows(equations, window)  # over the first cycles together a change would hide in the mean
    found = ((name, *moved.column(name)) for name in results.UNITS)
    bands: dict[str, Any] = {name: results.Band(value, value - half, value + half) for name, value, half in found}
    return {
        "coulomb": whole.coefficient("coulomb"),
        "viscous": whole.coefficient("viscous"),
        "offset_nm": offset,
        "gravity_error_nm": float(np.hypot(np.nan_to_num(x), np.nan_to_num(y))),
        "condition_number": condition,
        "correlation": correlation,
        "history": _history(own, window, bands),
    }


def _solve_paper(own: EnergyCycles, kept: EnergyCycles, model: str, window: int) -> dict[str, Any]:
    """Estimate after each cycle from the last k, (8), (14) or (20) of the paper; their median stands for the log."""
    sums, used = kept.sums, FRICTION[model]
    lengths = {"coulomb": sums.rectified_path_rad, "viscous": sums.square_speed_rad2_s}
    matrix = np.stack([lengths[name] for name in used], axis=1)
    found = {name: np.full(max(len(matrix) - window + 1, 0), results.NAN) for name in results.UNITS}
    for first in range(len(found["coulomb"])):
        rows = matrix[first : first + window]
        scale = np.linalg.norm(rows, axis=0)
        energy = sums.printed_net_j[first : first + window]
        solution, _, rank, _ = np.linalg.lstsq(rows / scale, energy, rcond=RANK_CUTOFF)
        if rank == len(used):
            for name, value in zip(used, solution / scale, strict=True):
                found[name][first] = value
    medians = {
        name: results.Coefficient.around(np.nanmedian(values))
        for name, values in found.items()
        if np.isfinite(values).any()
    }
    nothing = np.full(len(found["coulomb"]), results.NAN)
    history = _history(own, window, {n: results.Band(values, nothing, nothing) for n, values in found.items()})
    return {**medians, "history": history._replace(dissipated_j=own.sums.printed_net_j[history.cycle - 1])}


def _history(own: EnergyCycles, first: int, bands: dict[str, Any]) -> results.CoefficientHistory:
    """Return one row per cycle that counts, from the first one with an estimate on."""
    kept = np.flatnonzero(own.reason == KEPT)[first - 1 :]
    return results.CoefficientHistory(
        kept + 1,
        own.start_s[kept],
        own.stop_s[kept],
        **bands,
        net_energy_j=np.cumsum(own.sums.work_j)[kept],
        dissipated_j=own.sums.dissipated_j[kept],
        path_rad=own.sums.rectified_path_rad[kept],
        square_speed_rad2_s=own.sums.square_speed_rad2_s[kept],
    )


def _conclude(
    joint: results.JointFriction, seen: reasons.SignalRange, kept: EnergyCycles, standstill_rad_s: float
) -> tuple[results.JointFriction, tuple[Caution, ...]]:
    """Choose the method of a joint, let its intervals cover both methods, and drop what is not determined."""
    found = joint.regression
    if joint.reason and found is not None and found.doubt:
        joint = replace(joint, regression=None, reason=joint.reason + found.doubt)
    elif joint.reason and found is not None:
        same = ("coulomb", "viscous", "offset_nm", "condition_number", "correlation")
        taken = {name: getattr(found, name) for name in same}
        joint = replace(joint, method="regression", reason=(), no_energy=joint.reason, **taken)
    if joint.reason:
        return joint, reasons.cautions_of(joint)
    torque, speed = seen.in_motion(standstill_rad_s)
    # The half width beyond which an interval says nothing, by coefficient.
    largest = {"coulomb": MOST_UNCERTAIN * torque, "viscous": MOST_UNCERTAIN * torque / speed}
    determined = _determined(joint, largest)
    if determined.reason:
        return determined, reasons.cautions_of(determined)
    lost = tuple(
        Caution(code=f"{name}_not_determined", joint=joint.joint, numbers={"most": MOST_UNCERTAIN})
        for name in results.UNITS
        if np.isnan(getattr(determined, name).value) and not np.isnan(getattr(joint, name).value)
    )
    lost = (*reasons.repeated_cycles(joint, kept), *reasons.timing_cautions(joint), *lost)
    if joint.method == "regression":
        return determined, (Caution(code="from_regression", joint=joint.joint), *lost)
    alike = False
    if found is not None and joint.model == "combined" and isfinite(joint.coulomb.low):
        # Path and squared speed over whole cycles: of one speed profile their condition number is infinite.
        columns = np.column_stack([kept.sums.path_rad, kept.sums.square_speed_rad2_s])
        columns /= np.sqrt(kept.sums.square_speed_rad2_s)[:, None]
        alike = not np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) < HIGHEST_CONDITION
    if alike:
        lost = (Caution(code="one_speed_profile", joint=joint.joint), *lost)
    return _covering(determined, alike=alike), (*reasons.cautions_of(determined), *lost)


def _determined(joint: results.JointFriction, largest: dict[str, float]) -> results.JointFriction:
    """Drop the coefficients, of the log and of its history, whose intervals are too wide."""
    changed: dict[str, Any] = {}
    bands: dict[str, Any] = {}
    for name in results.UNITS:
        one: results.Coefficient = getattr(joint, name)
        if one.high - one.low > 2.0 * largest[name]:
            changed[name] = results.UNDETERMINED
        band: results.Band = getattr(joint.history, name)
        wide = band.high - band.low > 2.0 * largest[name]
        bands[name] = results.Band(*np.where(wide, results.NAN, band))
    found = replace(joint, history=joint.history._replace(**bands), **changed)
    if not changed or not all(np.isnan(getattr(found, name).value) for name in results.UNITS):
        return found
    return replace(found, reason=(Caution("wide_intervals", numbers={"most": MOST_UNCERTAIN}),))


def _covering(joint: results.JointFriction, *, alike: bool) -> results.JointFriction:
    """Widen the intervals of the log and of its history to the union with those of the regression.

    Where two methods disagree beyond their intervals neither interval holds what the method itself gets wrong, and a
    jackknife over cycles of one speed profile cannot see an error that all of them share.
    """
    if joint.regression is None:
        return joint
    for name in results.UNITS:
        one, other = getattr(joint, name), getattr(joint.regression, name)
        if (alike and np.isfinite(one.low)) or one.low > other.high or other.low > one.high:
            low, high = float(np.fmin(one.low, other.low)), float(np.fmax(one.high, other.high))
            value, lows, highs = getattr(joint.history, name)
            wider: dict[str, Any] = {name: results.Band(value, lows - (one.low - low), highs + (high - one.high))}
            joint = replace(joint, history=joint.history._replace(**wider), **{name: replace(one, low=low, high=high)})
    return joint
