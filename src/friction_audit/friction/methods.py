"""Energy cycles and torque regression: which of them gives the coefficients of a joint, and how sure the two are."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.cycles.energy_cycles import KEPT, EnergyCycles
from friction_audit.friction.cautions import cautions_of
from friction_audit.friction.history import UNDETERMINED, Coefficient, JointFriction, TorqueRegression
from friction_audit.friction.torque_regression import HIGHEST_CONDITION
from friction_audit.interaction.interaction import Caution, Interaction
from friction_audit.joint_log import Float

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
