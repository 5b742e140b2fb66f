"""Direction of motion as a column.

The recording was low-passed and a sign was not. A filtered sign would need the filter's width, which the data do not
carry: the sign is a ramp below the dead speed instead, and a fit takes only samples in which the direction is certain
(``JointData.moving``). What the filter smears beyond that stays as a small error next to reversals.
"""

import numpy as np

from friction_audit.diagnosis.joint_data import JointData
from friction_audit.joint_log import Float


def direction(data: JointData) -> Float:
    """Sign of the velocity, a ramp below the dead speed, shape (n,)."""
    return np.asarray(np.clip(data.dq / max(data.dead_speed_rad_s, 1e-9), -1.0, 1.0))
