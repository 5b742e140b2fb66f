"""How much of a torque written down by hand a candidate explains beside inertia, Coulomb and viscous friction."""

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import baseline


def share_explained(candidate: Effect, data: JointData, torque: Float) -> float:
    """Share of what the declared model leaves of a torque, shape (n,), by the best shape with possible factors."""
    used = data.used
    declared = np.column_stack([data.ddq, np.sign(data.dq), data.dq])[used]
    y = torque[used] - declared @ np.linalg.lstsq(declared, torque[used])[0]
    beside, best = Beside(declared, y), 0.0
    for shape in candidate.grid(data):
        factors, left = beside.fit(candidate.regressor(data, baseline(data), shape)[used])
        if candidate.admissible(factors, shape):
            best = max(best, 1.0 - left / float(np.sum(y**2)))
    return best
