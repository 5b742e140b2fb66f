"""Ripples between and beyond the orders of the grid: those that a scan of all orders finds the strongest."""

from collections.abc import Iterator

import numpy as np

from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.library import Library, extend_library
from friction_audit.diagnosis.order_scan import scan_orders
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.torque_ripple import COARSEST, order_range, spread_of
from friction_audit.effects.torque_ripple import EFFECT as CANDIDATE
from friction_audit.joint_log import Float

BESIDE = 0.5
"""Distance of two more orders beside a peak, times the spread of the position: a refinement stays between them."""


def with_scanned_orders(ground: Ground, library: Library, *effects: Float) -> Library:
    """Add the strongest orders of what a model leaves of the working rows, one within the grid and one beyond it.

    Args:
        ground: The joint.
        library: What may be named; it stays as it is where a ripple is not among it.
        effects: Columns of what was found so far, shape (m, p) each.
    """
    here = [entry for entry in library.entries if entry.candidate.name == CANDIDATE.name]
    return extend_library(library, _strongest(ground, effects)) if here else library


def _strongest(ground: Ground, effects: tuple[Float, ...]) -> Iterator[tuple[str, Nonlinear, Float]]:
    """Shapes about the peaks, with their columns."""
    data, rows = ground.data, ground.rows
    back, speed = _filtered_back(ground, ground.residual(*effects))
    order, gain = scan_orders(back, data.q, speed, *order_range(data), rows.whole_kernel, data.step_s)
    baseline, spread = ground.baseline(), spread_of(data)
    last = CANDIDATE.grid(data)[-1]["ripple_order"] + COARSEST / spread
    for part in (order <= last, order > last):
        if not gain[part].any():
            continue
        peak = float(order[part][np.argmax(gain[part])])
        for beside in (-BESIDE, 0.0, BESIDE):
            shape = {"ripple_order": peak + beside / spread}
            yield CANDIDATE.name, shape, rows.of(CANDIDATE.regressor(data, baseline, shape))


def _filtered_back(ground: Ground, residual: Float) -> tuple[Float, Float]:
    """Residual of the working rows filtered back onto the fine grid, shape (n,), and their speed, shape (w,)."""
    from scipy.signal import fftconvolve

    rows, data = ground.rows, ground.data
    filtered = rows.used.copy()
    filtered[rows.breakaway_row] = False
    kept = ground.working & filtered[rows.used]
    at = np.flatnonzero(rows.used)[kept] * rows.every
    spikes = np.zeros(len(data.t))
    spikes[at] = rows.back(np.where(kept, residual, 0.0))[kept]
    return np.asarray(fftconvolve(spikes, rows.kernel, mode="same")), np.abs(data.dq[at])
