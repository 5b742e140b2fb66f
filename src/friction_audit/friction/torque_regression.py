"""The same coefficients from the torque itself: a robust regression, with intervals that allow for autocorrelation.

    F_m + u = mu_c sgn(v) + mu_v v + b + c_x g_x + c_y g_y + B dv/dt

It weighs slow and fast motion alike where the energy method weighs by power, so the two differ when friction is not
Coulomb plus viscous, when torque and velocity are not simultaneous, or when the model lacks something.

Rows of one stroke share their errors, so strokes are left out one at a time, as cycles are by the default estimator.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.cycles.velocity import filter_velocity
from friction_audit.friction.equations import Equations
from friction_audit.friction.history import TorqueRegression
from friction_audit.friction.huber import huber_weights
from friction_audit.friction.settings import FEWEST_CYCLES
from friction_audit.friction.weighted import fit_windows
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float, median_step

CUTOFF_HZ = 20.0
ROW_RATE_HZ = 50.0
MOST_ROWS = 20_000
FEWEST_ROWS = 100


def regress_torque(interaction: Interaction, column: int, dead_band_rad_s: float) -> TorqueRegression | None:
    """Regress the torque of one joint on its motion, samples slower than the dead band left out.

    Args:
        interaction: Motion and torque.
        column: Joint, 0-based.
        dead_band_rad_s: Speed below which the sign of the velocity means nothing. [rad/s]

    Returns:
        The regression, or None with too few moving samples or strokes.
    """
    columns, torque, stroke = _rows(interaction, column, dead_band_rad_s)
    strokes = int(stroke[-1]) + 1 if len(stroke) else 0
    if len(torque) < FEWEST_ROWS or strokes < FEWEST_CYCLES:
        return None
    design = np.stack(list(columns.values()), axis=1)
    fit = fit_windows(_gather(tuple(columns), design, torque, stroke), strokes)
    return TorqueRegression(
        coulomb=fit.coefficient("coulomb"),
        viscous=fit.coefficient("viscous"),
        offset_nm=fit.coefficient("offset").value,
        inertia=fit.coefficient("inertia"),
        residual_rms_nm=float(np.sqrt(np.mean((torque - design @ fit.value[0]) ** 2))),
        samples=len(torque),
    )


def _rows(
    interaction: Interaction, column: int, dead_band_rad_s: float
) -> tuple[dict[str, Float], Float, NDArray[np.int64]]:
    """Return the columns by name, the torque, and the number of the stroke of each row."""
    t = interaction.t
    rate_hz = 1.0 / median_step(t)
    velocity = filter_velocity(interaction.dq[:, column], rate_hz=rate_hz, cutoff_hz=CUTOFF_HZ)
    load = interaction.torque[:, column]
    if interaction.compensation is not None:
        load = load + interaction.compensation[:, column]
    torque = filter_velocity(load, rate_hz=rate_hz, cutoff_hz=CUTOFF_HZ)
    index = np.arange(0, len(t), max(int(rate_hz / ROW_RATE_HZ), len(t) // MOST_ROWS, 1))
    index = index[np.abs(velocity[index]) > dead_band_rad_s]
    v = velocity[index]
    columns = {
        "coulomb": np.sign(v),
        "viscous": v,
        "offset": np.ones(len(v)),
        "inertia": _slope(velocity, t, index),
        **_gravity(interaction, column, index),
    }
    return columns, torque[index], np.cumsum(np.diff(np.sign(v), prepend=np.sign(v[:1])) != 0)


def _gather(names: tuple[str, ...], design: Float, torque: Float, stroke: NDArray[np.int64]) -> Equations:
    """Gather the rows by stroke, outliers counting less."""
    scale = np.linalg.norm(design, axis=0).clip(min=np.finfo(float).tiny)
    scaled = design / scale
    weighted = scaled * huber_weights(scaled, torque)[:, None]
    first = np.flatnonzero(np.diff(stroke, prepend=-1))
    return Equations(
        names=names,
        normal=np.add.reduceat(weighted[:, :, None] * scaled[:, None, :], first),
        right=np.add.reduceat(weighted * torque[:, None], first),
        scale=scale,
    )


def _slope(signal: Float, t: Float, index: NDArray[np.int64]) -> Float:
    """Differentiate a signal at some samples: central differences on uneven stamps, one-sided at the ends."""
    before, after = np.maximum(index - 1, 0), np.minimum(index, len(t) - 2)
    h, k = t[before + 1] - t[before], t[after + 1] - t[after]
    left, right = (signal[before + 1] - signal[before]) / h, (signal[after + 1] - signal[after]) / k
    return np.asarray((k * left + h * right) / (h + k), np.float64)


def _gravity(interaction: Interaction, column: int, index: NDArray[np.int64]) -> dict[str, Float]:
    """Return how gravity lies across the axis, where it turns: what does not turn is an offset."""
    if interaction.gravity_direction is None or interaction.gravity_index is None:
        q = interaction.q[index, column]
        sides = (np.sin(q), np.cos(q))
    else:
        at, direction = interaction.gravity_index, interaction.gravity_direction[:, column]
        sides = (np.interp(index, at, direction[:, 0]), np.interp(index, at, direction[:, 1]))
    named = zip(("gravity_x", "gravity_y"), sides, strict=True)
    return {name: side for name, side in named if len(side) and np.ptp(side) > LEAST_SWING}


LEAST_SWING = 1e-3
