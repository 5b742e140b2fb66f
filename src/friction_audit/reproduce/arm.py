"""Figs 12 to 14: a Panda guided by a hand, whose speed ends the cycles of all joints; and five methods."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.compensation.comparison.experiment import compare
from friction_audit.compensation.comparison.methods import FULL, METHODS, PAPER, SCENES
from friction_audit.compensation.comparison.result import Comparison, Row
from friction_audit.reproduce.claims import SECOND, Claim, Simulations, claim, share, spread
from friction_audit.reproduce.one_joint import BAND
from friction_audit.simulation.bench import Progress

# Slope of the cyclic energies, over that of the first two cycles, up to which they count as no longer rising.
SLOPE_BOUND = 0.1


def check_12(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that the joints' cycles end together, and that the net energy then stays."""
    arms = simulations["fig12"]
    ended = [np.diff(arm.truth.compensators["cycle"], axis=0) != 0 for arm in arms]
    alone = sum(int((one.any(axis=1) & ~one.all(axis=1)).sum()) for one in ended)
    ends = [np.flatnonzero(one[:, 0]) + 1 for one in ended]
    t = [arm.truth.motion.t[own] for arm, own in zip(arms, ends, strict=True)]
    energies = [arm.truth.compensators["energy_j"][own] for arm, own in zip(arms, ends, strict=True)]
    whole = [one.sum(axis=1, keepdims=True) for one in energies]
    # Slopes from the second cycle on, over those up to it; in the last column that of the arm.
    every = [(at, np.hstack(both)) for at, *both in zip(t, energies, whole, strict=True)]
    ratios = np.array([np.polyfit(at[SECOND:], e[SECOND:], 1)[0] / (e[SECOND] / at[SECOND]) for at, e in every])
    slopes, own_slopes = ratios[:, -1], ratios[:, :-1]
    stopped, joint = own_slopes < SLOPE_BOUND, int(np.argmax(own_slopes.max(axis=0)))
    leaves = np.array([np.abs(energy[SECOND + 1 :] / energy[SECOND] - 1.0).max() for energy in whole])
    estimated = [
        [arm.truth.compensators[f"estimated_{name}"][own] for name in ("coulomb_nm", "viscous_nms_per_rad")]
        for arm, own in zip(arms, ends, strict=True)
    ]
    negative = np.mean([((one < 0.0) | (other < 0.0))[np.isfinite(one)].mean() for one, other in estimated])
    inside, worst = leaves < BAND, own_slopes.max()
    arm: dict[str, Any] = {"slopes": spread(slopes, ""), "stopped": share(slopes < SLOPE_BOUND)}
    joints: dict[str, Any] = {"stopped": stopped.sum(), "joints": stopped.size, "worst": worst, "joint": joint + 1}
    kept: dict[str, Any] = {"inside": share(inside), "leaves": spread(leaves, "of it"), "negative": negative}
    return (
        claim("same_instants", alone, alone == 0, alone=alone),
        claim("arm_stops_rising", slopes.max(), (slopes < SLOPE_BOUND).all(), bound=SLOPE_BOUND, **arm),
        claim("joints_stop_rising", worst, stopped.all(), **joints),
        claim("arm_keeps", leaves.max(), inside.all(), band=BAND, **kept),
    )


# The paper's methods, from the steepest to the flattest net energy.
ORDER = ("none", "sigmoid", "disturbance_observer", "torque_regulation", "energy")
KEPT = 0.1  # slope, over that without compensation, up to which the net energy counts as kept


def compare_methods(seeds: int, progress: Progress | None = None) -> Comparison:
    """Try the paper's methods on the arm, without sweeps and margins."""
    (arm,) = (scene for scene in SCENES if scene.name == "panda")
    arm = replace(arm, tuning_seeds=0, margin_seeds=0)
    return compare(arm, seeds, [replace(method, sweeps=()) for method in METHODS if method.name in ORDER], progress)


def rows_of(comparison: Comparison, role: str) -> list[Row]:
    """Return the paper's methods with a role, in the paper's order."""
    rows = [comparison.row(name, role) or comparison.row(name, PAPER) for name in ORDER]
    return [row for row in rows if row is not None]


def in_words(rows: Sequence[Row], values: Sequence[float], factor: float, unit: str) -> str:
    """Return the methods with their values, largest first, and how often a loop was lost."""
    pairs = sorted(zip(values, rows, strict=True), key=lambda pair: -pair[0])
    order = " > ".join(f"{row.label} {factor * value:.3g}" for value, row in pairs)
    lost = [f"{row.label} lost in {1 - row.stable_share:.0%} of seeds" for row in rows if row.stable_share < 1.0]
    return "; ".join([f"{order} {unit}", *lost])


# Before a claim, by role: the paper does not make the second.
OWN = {PAPER: "", FULL: "own experiment, the observer compensates all that it observes: "}


def order(comparison: Comparison, role: str) -> Claim:
    """Check the order of the methods by the slope of the net energy."""
    rows = rows_of(comparison, role)
    slopes = [row.interval("energy_slope_w").value for row in rows]
    falls = np.diff(slopes) < 0.0
    words = in_words(rows, slopes, 1000.0, "mW")
    return claim("order", falls.sum(), falls.all(), own=role == FULL, before=OWN[role], order=words)


def keeps(comparison: Comparison) -> Claim:
    """Check that the proposed method keeps the net energy."""
    none, *_, proposed = rows_of(comparison, PAPER)
    slope, alone = (row.interval("energy_slope_w").value for row in (proposed, none))
    kept, stable = slope / alone, proposed.stable_share
    return claim("keeps", kept, abs(kept) < KEPT and stable == 1.0, kept=kept, bound=KEPT, stable=stable)


def peaks(comparison: Comparison) -> Claim:
    """Check the order of the methods by the largest torque."""
    rows = rows_of(comparison, PAPER)[:-1]
    drawn, raw = ([row.interval(name).value for row in rows] for name in ("drawn_peak_nm", "peak_torque_nm"))
    falls = np.diff(drawn) < 0.0
    as_drawn, as_read = (in_words(rows, found, 1.0, "N m") for found in (drawn, raw))
    return claim("peaks", falls.sum(), falls.all(), drawn=as_drawn, raw=as_read)


def plateaus(comparison: Comparison, role: str) -> Claim:
    """Check which method leaves least of the plateaus of Coulomb friction."""
    rows = rows_of(comparison, role)
    left = [abs(row.interval("coulomb_left").value) for row in rows]
    holds, words = left[-1] == min(left) and rows[-1].stable_share == 1.0, in_words(rows, left, 1.0, "of it left")
    return claim("least_plateaus", left[-1], holds, own=role == FULL, before=OWN[role], left=words)
