"""The estimator of the paper to the letter: viscous (8), Coulomb (14), combined over k cycles (20).

Departures: the pseudo-inverse is the left one, by singular values with a rank cut-off, because (19) prints the right
inverse; the work of a logged compensator and of its passivity controller enters the net energy with one sign
convention (10), (25); the sums are trapezoids on the real stamps.
"""

import numpy as np

from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.joint_log import Float

RANK_CUTOFF = 1e-6
"""Singular values below this share of the largest count as zero: cycles that are copies of one another."""


def estimate_paper(cycles: EnergyCycles, model: str, window: int) -> Float:
    """Estimate after each cycle from the last k cycles.

    Args:
        cycles: Cycles of one joint, m of them.
        model: ``"combined"``, ``"coulomb"`` or ``"viscous"``.
        window: k.

    Returns:
        Coulomb [N m] and viscous [N m s/rad] coefficients, shape (m - k + 1, 2), NaN where the model has none or k
        cycles cannot tell them apart.
    """
    sums = cycles.sums
    columns = {"coulomb": sums.rectified_path_rad, "viscous": sums.square_speed_rad2_s}
    used = [name for name in columns if model in (name, "combined")]
    matrix = _windows(np.stack([columns[name] for name in used], axis=1), window)
    energy = _windows(sums.printed_net_j, window)
    result = np.full((len(energy), 2), np.nan)
    for row, (a, e) in enumerate(zip(matrix, energy, strict=True)):
        scale = np.linalg.norm(a, axis=0)
        solution, _, rank, _ = np.linalg.lstsq(a / scale, e, rcond=RANK_CUTOFF)
        if rank == len(used):
            result[row, [list(columns).index(name) for name in used]] = solution / scale
    return result


def _windows(rows: Float, window: int) -> Float:
    """Return all runs of k consecutive rows, shape (m - k + 1, k, ...)."""
    if len(rows) < window:
        return np.empty((0, window, *rows.shape[1:]))
    return np.stack([rows[i : i + window] for i in range(len(rows) - window + 1)])
