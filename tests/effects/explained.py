"""How much of a torque an effect explains in addition to inertia, Coulomb and viscous friction."""

import numpy as np

from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import baseline


def share_explained(effect: Effect, data: JointData, torque: Float) -> float:
    """Share of what the nominal model leaves of a torque, shape (n,), by the best point with possible coefficients."""
    used = data.used
    nominal, y = np.column_stack([data.ddq, np.sign(data.dq), data.dq])[used], torque[used]

    def fit(own: Float) -> tuple[Float, float]:
        columns = np.column_stack([nominal, own])
        size = np.sqrt(np.mean(columns**2, axis=0))
        there = size > 0.0  # rounding of a zero coefficient may have an impossible sign
        size[~there] = 1.0
        coefficients = np.where(there, np.linalg.lstsq(columns / size, y, rcond=1e-10)[0] / size, 0.0)
        return coefficients[3:], float(np.sum((y - columns @ coefficients) ** 2))

    nothing, best = fit(np.zeros((len(y), 0)))[1], 0.0
    for shape in effect.grid(data):
        coefficients, left = fit(effect.regressor(data, baseline(data), shape)[used])
        if effect.admissible(coefficients, shape):
            best = max(best, 1.0 - left / nothing)
    return best
