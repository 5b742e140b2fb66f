"""How much of an effect's columns is noise of the motion: with as much noise again, they change by as much again.

A far side on a spring forgets the jump of friction that set it ringing, but goes on to ring with the noise of the
position, which no torque holds. A factor fitted to such a column is too small by the noise's share of its squares.

Reference: J. R. Cook, L. A. Stefanski, Simulation-extrapolation estimation in parametric measurement error models,
Journal of the American Statistical Association 89 (1994) 1314.
"""

from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.both_velocities import best_of_both
from friction_audit.diagnosis.ground import Ground
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal, grid_noise
from friction_audit.joint_log import Float

CORNER_SHARE = 0.4
"""Of half the grid's rate, up to which noise passes onto it."""
TAPS = 41


def noise_in_columns(
    ground: Ground, candidate: Effect, baseline: Nominal, shape: Nonlinear, rng: np.random.Generator
) -> Float:
    """What as much noise of position and velocity as there is changes in the columns of an effect, shape (m, p)."""
    data, rows = ground.data, ground.rows
    noisy, plain = (candidate.regressor(one, baseline, shape) for one in (noisier(data, rng), data))
    return rows.of(noisy - plain)


def noisier(data: JointData, rng: np.random.Generator) -> JointData:
    """The joint with as much noise of the position, and of the velocity where it is another's, as it has."""
    shake = _noise(len(data.t), grid_noise(data.q, differences=4), rng)
    slope = np.gradient(shake, data.step_s)
    if data.derived_from != "q":
        logged = _noise(len(data.t), grid_noise(data.dq if data.logged_dq is None else data.logged_dq), rng)
        crossover = data.crossover_hz
        slope = best_of_both(slope, logged, data.valid, data.step_s, crossover) if crossover > 0.0 else logged
    return replace(data, q=data.q + shake, dq=data.dq + slope, ddq=data.ddq + np.gradient(slope, data.step_s))


def _noise(samples: int, size: float, rng: np.random.Generator) -> Float:
    """Noise that is white up to the corner of the grid, of a standard deviation, shape (n,)."""
    from scipy.signal import firwin

    kernel = firwin(TAPS, CORNER_SHARE)
    white = np.convolve(rng.standard_normal(samples + TAPS - 1), kernel, mode="valid")
    return np.asarray(size / np.linalg.norm(kernel) * white)
