"""When a compensation is right, and how soon it gets there."""

import numpy as np

from friction_audit.compensation.counterfactuals import Scene
from friction_audit.compensation.port import Port
from friction_audit.compensation.records import ESTIMATED, Record
from friction_audit.compensation.result import Numbers, Passivity, ReplayHistory, Signals
from friction_audit.compensation.tally import (
    ACTED,
    COULOMB_APPLIED,
    COULOMB_ESTIMATED,
    FRICTION,
    GIVEN_OUT,
    NET,
    PATH_LENGTH,
    SQUARED,
    STATUS,
    STOP,
    VISCOUS_APPLIED,
    VISCOUS_ESTIMATED,
)
from friction_audit.joint_log import Float, read_only

RIGHT = 0.1
"""Share of the dissipation up to which what is left to the person, or given out, counts as right."""

IN_A_ROW = 3
"""So many cycles must be right, one after the other: a single one may be so by chance."""

UPDATES = 2
"""From this update of the coefficients on, the compensator is past its beginning."""


def share_left(history: ReplayHistory) -> Float:
    """Return what each cycle left to the person or gave out, over what friction took in it, shape (m,)."""
    usable = history.friction_j > 0.0
    return np.where(usable, np.abs(history.net_energy_j) / np.where(usable, history.friction_j, 1.0), np.inf)


def dissipation_removed(history: ReplayHistory, first: int = 0) -> float:
    """Return the share of the dissipation that compensation removed from a cycle on (0-based); NaN without cycles."""
    friction = float(history.friction_j[first:].sum())
    if not len(history.friction_j[first:]) or friction <= 0.0:
        return float("nan")
    return 1.0 - float(np.abs(history.net_energy_j[first:]).sum()) / friction


def first_updated(history: ReplayHistory) -> int:
    """Return the first cycle (0-based) that began with coefficients updated twice; their number if there is none."""
    updates = np.flatnonzero(history.status == ESTIMATED)
    return int(updates[UPDATES - 1]) + 1 if len(updates) >= UPDATES else len(history.status)


def first_right(history: ReplayHistory, first: int = 0) -> int | None:
    """Return the first cycle (0-based), not before ``first``, from which on IN_A_ROW are right; None if never."""
    right = share_left(history)[first:] <= RIGHT
    if len(right) < IN_A_ROW:
        return None
    runs = np.convolve(right, np.ones(IN_A_ROW), "valid") == IN_A_ROW
    return first + int(np.argmax(runs)) if runs.any() else None


def read_history(rows: Float, t: Float) -> ReplayHistory:
    """Return the rows of a tally, shape (m, COLUMNS), by their names."""
    stop = rows[:, STOP].astype(np.int64)
    start = np.concatenate([[0], stop[:-1]]).astype(np.int64)[: len(stop)]
    return ReplayHistory(
        start=start,
        stop=stop,
        start_s=t[start],
        stop_s=t[stop],
        friction_j=rows[:, FRICTION],
        net_energy_j=rows[:, NET],
        path_rad=rows[:, PATH_LENGTH],
        square_speed_rad2_s=rows[:, SQUARED],
        coulomb_applied_nm=rows[:, COULOMB_APPLIED],
        viscous_applied_nms_per_rad=rows[:, VISCOUS_APPLIED],
        coulomb_estimated_nm=rows[:, COULOMB_ESTIMATED],
        viscous_estimated_nms_per_rad=rows[:, VISCOUS_ESTIMATED],
        acted=rows[:, ACTED] == 1,
        status=rows[:, STATUS].astype(np.int64),
    )


def measure(port: Port, without: Signals, replayed: Signals, history: ReplayHistory, tally: Record) -> Numbers:
    """Return what a replay comes to.

    Args:
        port: The recording.
        without: The joint without a compensator.
        replayed: The joint with it, fewer samples if it diverged.
        history: Per cycle.
        tally: What was counted.
    """
    from friction_audit.compensation.tally import largest_sum, sum_up

    samples = len(replayed.t)
    recorded, before, after = (
        sum_up(*map(read_only, columns))
        for columns in (
            (port.t, port.dq, port.torque),
            (without.t, without.dq, without.interaction_nm),
            (replayed.t, replayed.dq, replayed.interaction_nm),
        )
    )
    return Numbers(
        energy_recorded_j=recorded[0],
        energy_without_j=before[0],
        energy_with_j=after[0],
        dissipation_removed=dissipation_removed(history),
        dissipation_removed_updated=dissipation_removed(history, first_updated(history)),
        peak_torque_without_nm=before[2],
        peak_torque_with_nm=after[2],
        rms_torque_without_nm=before[1],
        rms_torque_with_nm=after[1],
        peak_compensation_nm=largest_sum(replayed.compensation_nm, replayed.passivity_nm),
        peak_rate_nm_s=float(tally["fastest_nm_s"]),
        limited_fraction=float(tally["limited"]) / samples,
        cycles_to_converge=first_right(history),
        diverged_s=float(port.t[samples]) if samples < len(port.t) else float("nan"),
    )


def measure_passivity(history: ReplayHistory, tally: Record, t: Float) -> Passivity:
    """Return how passive the compensated joint stayed."""
    given_out = history.net_energy_j < -GIVEN_OUT * np.abs(history.friction_j)
    activation = int(tally["activation"])
    return Passivity(
        violations=int(tally["violations"]),
        violations_since_activation=int(tally["active_violations"]),
        active_cycles=int(given_out.sum()),
        lowest_j=float(tally["lowest_j"]),
        lowest_since_activation_j=float(tally["lowest_active_j"]),
        reserve_j=float(tally["reserve_j"]),
        activation_s=float(t[activation]) if activation >= 0 else float("nan"),
        injected_j=float(tally["injected_j"]),
        unserved_j=float(tally["unserved_j"]),
        active_fraction=float(tally["acting_s"]) / float(t[-1] - t[0]),
        hidden=bool(tally["hidden"]),
    )


def model_error(scene: Scene, port: Port, without: Signals) -> float:
    """Return how far the simulated joint's motion without a compensator is from the recorded one, over this.

    NaN where nothing is simulated, or a compensator was active in the recording: then it moves otherwise.
    """
    if scene.joint is None or len(port.logged) or len(without.t) < len(port.t):
        return float("nan")
    return float(np.sqrt(np.sum((without.dq - port.dq) ** 2) / max(np.sum(port.dq**2), np.finfo(float).tiny)))
