"""The same coefficients from the torque itself: a robust regression with autocorrelation-consistent intervals.

    F_m + u = mu_c sgn(v) + mu_v v + b + c_x g_x + c_y g_y + B dv/dt

It weighs slow and fast motion alike where the energy method weighs by power, so the two differ when friction is not
Coulomb plus viscous, when torque and velocity are not simultaneous, or when the model lacks something.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.cycles.velocity import filter_velocity
from friction_audit.friction.history import Coefficient, TorqueRegression
from friction_audit.friction.robust_regression import huber_weights, newey_west_errors, solve_weighted
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float, median_step

CUTOFF_HZ = 20.0
ROW_RATE_HZ = 50.0
MOST_ROWS = 20_000
LAG_S = 0.5
"""Longest correlation time that the intervals allow for; friction and model errors repeat within a stroke."""

FEWEST_ROWS = 100
QUANTILE = 1.959963984540054
"""Of the normal distribution, for 95 % intervals."""


def regress_torque(interaction: Interaction, column: int, dead_band_rad_s: float) -> TorqueRegression | None:
    """Regress the torque of one joint on its motion, samples slower than the dead band left out.

    Args:
        interaction: Motion and torque.
        column: Joint, 0-based.
        dead_band_rad_s: Speed below which the sign of the velocity means nothing. [rad/s]

    Returns:
        The regression, or None with too few moving samples.
    """
    rows = _rows(interaction, column, dead_band_rad_s)
    if rows is None:
        return None
    design, torque, spacing_s = rows
    scale = np.linalg.norm(design, axis=0)
    scaled = design / scale
    weights = huber_weights(scaled, torque)
    solution, inverse = solve_weighted(scaled, torque, weights)
    residual = torque - scaled @ solution
    lags = max(int(LAG_S / spacing_s), 1)
    half = QUANTILE * newey_west_errors(scaled * (weights * residual)[:, None], inverse, lags) / scale
    value = solution / scale
    coulomb, viscous = (
        Coefficient(value=float(value[k]), low=float(value[k] - half[k]), high=float(value[k] + half[k]))
        for k in range(2)
    )
    return TorqueRegression(
        coulomb=coulomb,
        viscous=viscous,
        offset_nm=float(value[2]),
        inertia_kg_m2=float(value[3]),
        residual_rms_nm=float(np.sqrt(np.mean(residual**2))),
        samples=len(torque),
    )


def _rows(interaction: Interaction, column: int, dead_band_rad_s: float) -> tuple[Float, Float, float] | None:
    """Return the design matrix, the torque and the spacing of its rows in time."""
    t = interaction.t
    rate_hz = 1.0 / median_step(t)
    velocity = filter_velocity(interaction.dq[:, column], rate_hz=rate_hz, cutoff_hz=CUTOFF_HZ)
    load = interaction.torque[:, column]
    if interaction.compensation is not None:
        load = load + interaction.compensation[:, column]
    torque = filter_velocity(load, rate_hz=rate_hz, cutoff_hz=CUTOFF_HZ)
    stride = max(int(rate_hz / ROW_RATE_HZ), len(t) // MOST_ROWS, 1)
    index = np.arange(0, len(t), stride)
    index = index[np.abs(velocity[index]) > dead_band_rad_s]
    if len(index) < FEWEST_ROWS:
        return None
    v = velocity[index]
    acceleration = _slope(velocity, t, index)
    columns = [np.sign(v), v, np.ones(len(v)), acceleration, *_gravity(interaction, column, index)]
    kept = [c for c in columns if np.ptp(c) > 0 or c is columns[2]]
    return np.stack(kept, axis=1), torque[index], stride / rate_hz


def _slope(signal: Float, t: Float, index: NDArray[np.int64]) -> Float:
    """Differentiate a signal at some samples: central differences on uneven stamps, one-sided at the ends."""
    before, after = np.maximum(index - 1, 0), np.minimum(index, len(t) - 2)
    h, k = t[before + 1] - t[before], t[after + 1] - t[after]
    left, right = (signal[before + 1] - signal[before]) / h, (signal[after + 1] - signal[after]) / k
    return np.asarray((k * left + h * right) / (h + k), np.float64)


def _gravity(interaction: Interaction, column: int, index: NDArray[np.int64]) -> list[Float]:
    if interaction.gravity_direction is None or interaction.gravity_index is None:
        q = interaction.q[index, column]
        return [np.sin(q), np.cos(q)]
    at, direction = interaction.gravity_index, interaction.gravity_direction[:, column]
    sides = [np.interp(index, at, direction[:, k]) for k in range(2)]
    return [side for side in sides if np.ptp(side) > LEAST_SWING]


LEAST_SWING = 1e-3
"""A gravity direction that does not turn is a constant, and the offset has that column already."""
