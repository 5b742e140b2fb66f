"""Why a joint has no estimate, in a sentence with the motion that would help."""

import numpy as np

from friction_audit.cycles.energy_cycles import GAP, KEPT, ONE_WAY, OPEN, SMALL, EnergyCycles, Int
from friction_audit.friction.settings import FrictionSettings
from friction_audit.friction.weighted import FEWEST_CYCLES

SMALLEST_SPREAD = 0.1
"""Coefficient of variation of the speed over the path below which a log has one speed only."""

ADVICE = {
    GAP: "a hole in the log lies in every one of these; record without dropping samples",
    OPEN: "gravity is still in the torque and no path returns to where it began; remove gravity (--gravity model with "
    "--robot or --urdf, or log it), or move back and forth between the same postures",
    SMALL: "in none of these did every selected joint move far enough; move all joints, select fewer (--joints), or "
    "lower --min-path",
    ONE_WAY: "the joint moved one way only and never back, so there is no closed energy cycle and friction cannot be "
    "told from gravity or a torque offset; move it there and back, several times and at different speeds",
}


def missing_motion(cycles: EnergyCycles, column: int, peak_rad_s: float, settings: FrictionSettings) -> str:
    """Say why the cycles of one joint allow no estimate; empty if they do.

    Args:
        cycles: All cycles of this joint.
        column: Joint, 0-based, for its thresholds.
        peak_rad_s: Its largest speed. [rad/s]
        settings: Settings of the estimate.
    """
    if not len(cycles.joint):
        return _no_cycle(float(cycles.initiation[column]), float(cycles.termination[column]), peak_rad_s)
    if not cycles.sums.path_rad.any():
        return "its position never changes while its velocity does; check that q and dq are of this joint (--map q=...)"
    kept = int((cycles.reason == KEPT).sum())
    fewest = FEWEST_CYCLES if settings.estimator == "weighted" else settings.cycles_per_point
    if kept >= fewest:
        return ""
    left_out = cycles.reason[cycles.reason != KEPT]
    if kept == 0:
        return f"{_count(len(left_out))} found, none usable: {ADVICE[_most_common(left_out)]}"
    shortage = f"only {_count(kept)} usable, at least {fewest} are needed"
    if len(left_out) > kept:
        return f"{shortage}; {len(left_out)} more were found and left out: {ADVICE[_most_common(left_out)]}"
    return f"{shortage}; record more strokes back and forth"


def one_speed(cycles: EnergyCycles) -> str:
    """Say that Coulomb and viscous friction cannot be told apart because all motion has one speed; empty if they can.

    Args:
        cycles: Cycles of one joint that count.
    """
    parts = cycles.parts
    path, square = parts.path_rad.ravel(), parts.square_speed_rad2_s.ravel()
    used = (path > 0) & (square > 0)
    path, speed = path[used], square[used] / path[used]
    mean = float(np.average(speed, weights=path))
    spread = float(np.sqrt(np.average((speed - mean) ** 2, weights=path))) / mean
    if spread >= SMALLEST_SPREAD:
        return ""
    level = float(parts.dissipated_j.sum() / path.sum())
    return (
        f"all motion has one speed ({mean:.2g} rad/s, spread {100 * spread:.0f} %): friction there is {level:.3f} N m, "
        "but its Coulomb and viscous parts cannot be told apart; move at two or more speeds"
    )


def _no_cycle(initiation: float, termination: float, peak_rad_s: float) -> str:
    if peak_rad_s <= initiation:
        return (
            f"did not move: its peak speed {peak_rad_s:.1g} rad/s stays below the initiation threshold "
            f"{initiation:.2g} rad/s; move it back and forth faster, or lower the thresholds (--thresholds auto)"
        )
    return (
        f"no complete energy cycle: it moved (peak {peak_rad_s:.2g} rad/s) but never came back below {termination:.2g} "
        "rad/s after exceeding the initiation threshold; pause between strokes, or try --thresholds auto"
    )


def _most_common(reasons: Int) -> int:
    return int(np.bincount(reasons).argmax())


def _count(cycles: int) -> str:
    return "1 cycle is" if cycles == 1 else f"{cycles} cycles are"
